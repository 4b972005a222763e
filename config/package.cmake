# The build folder as a CMake package: games, clients and tests of one's own find what was built here with
# find_package(zoned) and zoned_DIR=build (config/guides). CMakeLists.txt includes this once all libraries are known.
set(ZONED_PACKAGED zoned_asio zoned_beast zoned_proto zoned_config_proto
  zoned_shared_core zoned_shared_math zoned_shared_clock zoned_shared_motion zoned_shared_wire
  zoned_server_compute zoned_server_spatial zoned_server_mailbox zoned_server_world zoned_server_physics zoned_server_ai
  zoned_server_interest zoned_server_replication zoned_server_zone zoned_server_assets zoned_server_recording zoned_server_store
  zoned_server_config zoned_server_rules zoned_server_scripting zoned_server_net zoned_server_session zoned_server_admin zoned_server_cluster zoned_server_app
  zoned_client_sim_link zoned_client_sim_view zoned_client_sim_bot zoned_client_sim_measure zoned_client_sim_app)
if(ZONED_TESTS)
  list(APPEND ZONED_PACKAGED zoned_tests_harness)
endif()
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
configure_file(config/zoned-config.cmake.in ${PROJECT_BINARY_DIR}/zoned-config.cmake @ONLY)
