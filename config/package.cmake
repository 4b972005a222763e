# zoned as a CMake package: games, clients and tests of one's own find it with find_package(zoned), installed or, by
# zoned_DIR=build, where it was built (config/guides). CMakeLists.txt includes this once all libraries are known.
set(ZONED_PACKAGED zoned_server_main zoned_asio zoned_beast zoned_proto zoned_config_proto
  zoned_shared_core zoned_shared_math zoned_shared_clock zoned_shared_motion zoned_shared_wire
  zoned_server_compute zoned_server_spatial zoned_server_mailbox zoned_server_world zoned_server_physics zoned_server_ai
  zoned_server_interest zoned_server_replication zoned_server_zone zoned_server_assets zoned_server_recording zoned_server_store
  zoned_server_config zoned_server_rules zoned_server_scripting zoned_server_net zoned_server_session zoned_server_admin zoned_server_cluster zoned_server_app
  zoned_client_sim_link zoned_client_sim_view zoned_client_sim_audit zoned_client_sim_bot zoned_client_sim_measure zoned_client_sim_app zoned_tests_harness)
foreach(NAME ${ZONED_PACKAGED})
  string(REGEX REPLACE "^zoned_" "" SHORT ${NAME})
  set_target_properties(${NAME} PROPERTIES EXPORT_NAME ${SHORT})
endforeach()
export(TARGETS ${ZONED_PACKAGED} NAMESPACE zoned:: FILE ${PROJECT_BINARY_DIR}/zoned-targets.cmake)

# Who includes our headers compiles as we do, warnings aside: the processor's options say how vectors lie in memory, and the
# same input gives the same bits.
get_directory_property(ZONED_CODE_OPTIONS COMPILE_OPTIONS)
list(FILTER ZONED_CODE_OPTIONS EXCLUDE REGEX "^(-W|--param|-fpch)")
get_directory_property(ZONED_CODE_LINK_OPTIONS LINK_OPTIONS)
list(FILTER ZONED_CODE_LINK_OPTIONS EXCLUDE REGEX "^(-B|-fuse-ld)")  # a user's machine need not have our linker
configure_file(config/zoned-config.cmake.in ${PROJECT_BINARY_DIR}/zoned-config.cmake @ONLY)

# The component `development`: headers and libraries, without what a debugger would read of them.
set(ZONED_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/zoned)
set(ZONED_HEADERS ${CMAKE_INSTALL_INCLUDEDIR}/zoned)
install(TARGETS ${ZONED_PACKAGED} EXPORT zoned COMPONENT development ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/zoned)
install(CODE "file(GLOB LIBRARIES \$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_LIBDIR}/zoned/*.a)
execute_process(COMMAND ${CMAKE_STRIP} --strip-debug \${LIBRARIES} COMMAND_ERROR_IS_FATAL ANY)" COMPONENT development)
install(EXPORT zoned NAMESPACE zoned:: FILE zoned-targets.cmake DESTINATION ${ZONED_CMAKE_DIR} COMPONENT development)
install(FILES ${PROJECT_BINARY_DIR}/zoned-config.cmake DESTINATION ${ZONED_CMAKE_DIR} COMPONENT development)
file(GLOB_RECURSE HEADERS CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR} server/*.h shared/*.h client-sim/*.h kernels/*.h tests/harness/*.h)
foreach(HEADER ${HEADERS})
  get_filename_component(FOLDER ${HEADER} DIRECTORY)
  install(FILES ${HEADER} DESTINATION ${ZONED_HEADERS}/${FOLDER} COMPONENT development)
endforeach()
install(DIRECTORY ${PROJECT_BINARY_DIR}/generated/proto DESTINATION ${ZONED_HEADERS} COMPONENT development FILES_MATCHING PATTERN "*.pb.h")
