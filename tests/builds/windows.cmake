# The command under Wine. Its package is tested by './dev package --windows'.
if(TARGET oncollide_tool AND Python3_EXECUTABLE)
  add_test(NAME builds.TheCommandDoesAsOnOtherSystems
    COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/command_hashes.py ${CMAKE_CROSSCOMPILING_EMULATOR} $<TARGET_FILE:oncollide_tool>)
  set_tests_properties(builds.TheCommandDoesAsOnOtherSystems PROPERTIES TIMEOUT 900)
endif()
