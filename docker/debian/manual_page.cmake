# A manual page from what a program says of itself: cmake -DPROGRAM= -DVERSION= -DOUT= -P manual_page.cmake
get_filename_component(NAME ${PROGRAM} NAME)
string(TOUPPER ${NAME} TITLE)
string(REPLACE "-" "\\-" SHOWN ${NAME})
execute_process(COMMAND ${PROGRAM} --help OUTPUT_VARIABLE HELP RESULT_VARIABLE FAILED)
if(FAILED)
  message(FATAL_ERROR "${PROGRAM} --help failed")
endif()
string(REGEX MATCH "^[^\n]*" SUMMARY "${HELP}")
string(REGEX REPLACE "^[^:]*: *" "" SUMMARY "${SUMMARY}")

# verbatim(VARIABLE text): escapes what groff would read as its own.
function(verbatim VARIABLE TEXT)
  string(REPLACE "\\" "\\e" TEXT "${TEXT}")
  string(REPLACE "-" "\\-" TEXT "${TEXT}")
  string(REPLACE "\n." "\n\\&." TEXT "${TEXT}")
  string(REPLACE "\n'" "\n\\&'" TEXT "${TEXT}")
  set(${VARIABLE} ".nf\n${TEXT}\n.fi\n" PARENT_SCOPE)
endfunction()

verbatim(BODY "${HELP}")
string(CONCAT PAGE ".TH ${TITLE} 1 \"\" \"zoned ${VERSION}\" \"User Commands\"\n"
  ".SH NAME\n${SHOWN} \\- ${SUMMARY}\n.SH USAGE\n${BODY}"
  ".SH EXIT STATUS\n0: good. 1: a verdict or a comparison failed. 2: bad usage or a mistake in the config. "
  "3: the environment, such as a port in use.\n")
file(WRITE ${OUT} "${PAGE}")
