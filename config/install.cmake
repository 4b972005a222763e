# cmake --install: programs, the worlds that come with them, guides and notices. What a world names (geometry, policies) is
# installed beside it, so that the installed `zoned serve --config <a world>` runs.
include(GNUInstallDirs)
set(ZONED_DATA_DIR ${CMAKE_INSTALL_DATADIR}/zoned)

install(TARGETS zoned client-sim RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
file(GLOB WORLDS CONFIGURE_DEPENDS config/*.txtpb)
install(FILES ${WORLDS} DESTINATION ${ZONED_DATA_DIR}/worlds)
install(DIRECTORY config/geometry config/training DESTINATION ${ZONED_DATA_DIR}/worlds)
# The schema explains every setting.
install(DIRECTORY proto/config DESTINATION ${ZONED_DATA_DIR}/proto FILES_MATCHING PATTERN "*.proto")
install(DIRECTORY docker/monitoring DESTINATION ${ZONED_DATA_DIR})

install(FILES README.md config/npcs.md config/training.md proto/WIRE.md docker/debian/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY config/guides DESTINATION ${CMAKE_INSTALL_DOCDIR})

# The manual page is made of what --help says.
set(MANUAL_PAGES)
foreach(PROGRAM zoned client-sim)
  set(PAGE ${PROJECT_BINARY_DIR}/man/${PROGRAM}.1)
  add_custom_command(OUTPUT ${PAGE} VERBATIM
    COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:${PROGRAM}> -DVERSION=${PROJECT_VERSION} -DOUT=${PAGE}
      -P ${PROJECT_SOURCE_DIR}/docker/debian/manual_page.cmake
    DEPENDS ${PROGRAM} docker/debian/manual_page.cmake)
  list(APPEND MANUAL_PAGES ${PAGE})
endforeach()
add_custom_target(manual_pages ALL DEPENDS ${MANUAL_PAGES})
install(FILES ${MANUAL_PAGES} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
