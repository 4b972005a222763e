# cmake --install: programs, the worlds that come with them, guides and notices. What a world names (geometry, policies) is
# installed beside it, so that the installed `zoned serve --config <a world>` runs.
install(TARGETS zoned client-sim RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
file(GLOB WORLDS CONFIGURE_DEPENDS config/*.txtpb)
install(FILES ${WORLDS} DESTINATION ${ZONED_DATA_DIR}/worlds)
install(DIRECTORY config/geometry config/methods config/scripts config/training DESTINATION ${ZONED_DATA_DIR}/worlds)
# The schema explains every setting.
install(DIRECTORY proto/config DESTINATION ${ZONED_DATA_DIR}/proto FILES_MATCHING PATTERN "*.proto")
install(DIRECTORY docker/monitoring DESTINATION ${ZONED_DATA_DIR})

install(FILES README.md config/npcs.md config/training.md proto/WIRE.md docker/debian/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY config/guides DESTINATION ${CMAKE_INSTALL_DOCDIR})

# The client library for games: header, pkg-config and CMake targets, modules for Python, C# and Godot,
# examples.
set(ZONED_LIBRARY ${PROJECT_SOURCE_DIR}/client-sim/library)
install(TARGETS zoned_client EXPORT zoned_client
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} NAMELINK_COMPONENT development)
install(FILES ${ZONED_LIBRARY}/zoned_client.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
install(EXPORT zoned_client NAMESPACE zoned_client:: FILE zoned_client-config.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/zoned_client COMPONENT development)
file(RELATIVE_PATH ZONED_CLIENT_PREFIX ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(${ZONED_LIBRARY}/zoned_client.pc.in ${PROJECT_BINARY_DIR}/zoned_client.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/zoned_client.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
install(DIRECTORY ${ZONED_LIBRARY}/python ${ZONED_LIBRARY}/csharp ${ZONED_LIBRARY}/c ${ZONED_LIBRARY}/godot
  DESTINATION ${ZONED_DATA_DIR}/client FILES_MATCHING PATTERN "*.py" PATTERN "*.cs" PATTERN "*.[ch]" PATTERN "*.gdextension")
# The client for pages: module, its types, and an example.
if(ZONED_WEB_CLIENT)
  install(FILES ${WEB_CLIENT} ${PROJECT_BINARY_DIR}/web/zoned_client.js ${PROJECT_SOURCE_DIR}/client-sim/web/zoned_client.d.ts
    ${PROJECT_SOURCE_DIR}/client-sim/web/look_around.ts ${PROJECT_SOURCE_DIR}/client-sim/web/look_around.html DESTINATION ${ZONED_DATA_DIR}/client/web)
endif()

# The programs say themselves what their manual pages and completions hold; client-sim does so by --help.
set(MAN ${PROJECT_BINARY_DIR}/man)
file(MAKE_DIRECTORY ${MAN})
add_custom_command(OUTPUT ${MAN}/zoned.1 COMMAND zoned manual > ${MAN}/zoned.1 DEPENDS zoned VERBATIM)
add_custom_command(OUTPUT ${MAN}/zoned.bash COMMAND zoned completion bash > ${MAN}/zoned.bash DEPENDS zoned VERBATIM)
add_custom_command(OUTPUT ${MAN}/client-sim.1 VERBATIM
  COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:client-sim> -DVERSION=${PROJECT_VERSION} -DOUT=${MAN}/client-sim.1
    -P ${PROJECT_SOURCE_DIR}/docker/debian/manual_page.cmake
  DEPENDS client-sim docker/debian/manual_page.cmake)
add_custom_target(manual_pages ALL DEPENDS ${MAN}/zoned.1 ${MAN}/zoned.bash ${MAN}/client-sim.1)
install(FILES ${MAN}/zoned.1 ${MAN}/client-sim.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${MAN}/zoned.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME zoned)
