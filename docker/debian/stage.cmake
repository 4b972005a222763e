# Run by CPack before it packs: adds the unit, the settings of the service, and compressed documents.
set(ROOT ${CPACK_TEMPORARY_DIRECTORY}/Unspecified)
set(DEVELOPMENT ${CPACK_TEMPORARY_DIRECTORY}/development)
set(SOURCE ${CPACK_ZONED_SOURCE_DIR})
set(DEBIAN ${SOURCE}/docker/debian)
set(DOC ${ROOT}/usr/share/doc/zoned)

file(COPY ${DEBIAN}/zoned.service DESTINATION ${ROOT}/lib/systemd/system)
file(MAKE_DIRECTORY ${ROOT}/etc/default)
file(COPY_FILE ${DEBIAN}/default ${ROOT}/etc/default/zoned)

# The world of the service: valley, closed for all but holders of tickets.
file(READ ${SOURCE}/config/valley.txtpb WORLD)
foreach(BLOCK network session audit)
  string(REGEX MATCHALL "\n${BLOCK} {[^\n]*}\n" FOUND "${WORLD}")
  list(LENGTH FOUND COUNT)
  if(NOT COUNT EQUAL 1)
    message(FATAL_ERROR "valley.txtpb has ${COUNT} lines of ${BLOCK}, one was expected")
  endif()
  string(REPLACE "${FOUND}" "\n" WORLD "${WORLD}")
endforeach()
file(READ ${DEBIAN}/settings.txtpb SETTINGS)
# What it names lies beside the world that it was made from.
string(REPLACE "\"geometry/" "\"/usr/share/zoned/worlds/geometry/" WORLD "${WORLD}")
file(MAKE_DIRECTORY ${ROOT}/etc/zoned)
file(WRITE ${ROOT}/etc/zoned/world.txtpb "${WORLD}\n${SETTINGS}")

function(compressed FROM TO)
  execute_process(COMMAND gzip -9n -c ${FROM} OUTPUT_FILE ${TO} COMMAND_ERROR_IS_FATAL ANY)
endfunction()
compressed(${DEBIAN}/changelog ${DOC}/changelog.gz)
set(DEVELOPMENT_DOC ${DEVELOPMENT}/usr/share/doc/zoned-dev)
file(COPY ${DEBIAN}/copyright DESTINATION ${DEVELOPMENT_DOC})
compressed(${DEBIAN}/changelog ${DEVELOPMENT_DOC}/changelog.gz)
file(GLOB PAGES ${ROOT}/usr/share/man/man1/*.1)
foreach(PAGE ${PAGES})
  compressed(${PAGE} ${PAGE}.gz)
  file(REMOVE ${PAGE})
endforeach()

# Modes of the source tree are its owner's business.
execute_process(COMMAND chmod -R u=rwX,go=rX ${ROOT} ${DEVELOPMENT} COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND find ${ROOT} ${DEVELOPMENT} -type f -not -path "${ROOT}/usr/bin/*" -exec chmod 0644 {} + COMMAND_ERROR_IS_FATAL ANY)
