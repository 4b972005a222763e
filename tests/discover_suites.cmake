# Writes ctest's list of the suites of one program of GoogleTest, one test a suite: a process for each of three thousand tests
# would take longer than most of them do. -DPROGRAM=... -DNAME=... -DFILTER=... -DTIMEOUT=seconds -DCOST=seconds
# -DPROCESSORS=slots -DOUT=...
set(FILTER_OPTION)
if(FILTER)
  set(FILTER_OPTION --gtest_filter=${FILTER})
endif()
execute_process(COMMAND ${PROGRAM} --gtest_list_tests ${FILTER_OPTION}
  OUTPUT_VARIABLE LISTED RESULT_VARIABLE FAILED TIMEOUT 60)
if(FAILED)
  message(FATAL_ERROR "${PROGRAM} --gtest_list_tests failed: ${FAILED}")
endif()
# Suites stand at the start of a line and end in a dot, tests are indented.
string(REGEX MATCHALL "(^|\n)[A-Za-z_][A-Za-z0-9_/]*\\." SUITES "${LISTED}")
if(NOT SUITES)
  message(FATAL_ERROR "${PROGRAM} lists no tests")
endif()
set(TESTS "")
foreach(SUITE ${SUITES})
  string(REGEX REPLACE "[\n.]" "" SUITE "${SUITE}")
  string(APPEND TESTS "add_test([=[${NAME}.${SUITE}]=] [=[${PROGRAM}]=] [=[--gtest_filter=${SUITE}.*${FILTER}]=])\n"
    "set_tests_properties([=[${NAME}.${SUITE}]=] PROPERTIES TIMEOUT ${TIMEOUT} COST ${COST} PROCESSORS ${PROCESSORS})\n")
endforeach()
file(WRITE ${OUT} "${TESTS}")
