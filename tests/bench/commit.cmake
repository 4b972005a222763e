# Writes OUT, a header that names the commit which is built; touches it only where that changed.
execute_process(COMMAND git -C ${SOURCE} describe --always --dirty --abbrev=12 --exclude=*
  OUTPUT_VARIABLE COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(COMMIT STREQUAL "")
  set(COMMIT "unknown")
endif()
set(TEXT "// The commit that was built.\n#pragma once\n#define ZONED_COMMIT \"${COMMIT}\"\n")
set(OLD "")
if(EXISTS ${OUT})
  file(READ ${OUT} OLD)
endif()
if(NOT OLD STREQUAL TEXT)
  file(WRITE ${OUT} ${TEXT})
endif()
