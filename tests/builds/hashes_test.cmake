# Compares the output of a program with known lines: cmake -DPROGRAM=program;with;arguments -DKNOWN=file -P hashes_test.cmake
execute_process(COMMAND ${PROGRAM} OUTPUT_VARIABLE output RESULT_VARIABLE failed)
string(REPLACE "\r" "" output "${output}") # of Windows
file(READ ${KNOWN} known)
if(failed OR NOT output STREQUAL known)
  message(FATAL_ERROR "${PROGRAM} ended with ${failed} and printed\n${output}and not\n${known}")
endif()
