# Compares the output of portable/, built with another compiler or given as PROGRAM, with known results.
#   cmake -DSOURCE=project -DWORK=scratch folder -DCOMPILER=c++ -DEIGEN=folder -DFMT=folder [-DPROCESSOR=aarch64 -DRUNNER=qemu-aarch64]
#         -P portable_test.cmake
#   cmake -DPROGRAM=portable -P portable_test.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)
if(NOT PROGRAM)
  file(REMOVE_RECURSE ${WORK})
  file(MAKE_DIRECTORY ${WORK}/headers)
  file(CREATE_LINK ${EIGEN}/Eigen ${WORK}/headers/Eigen SYMBOLIC) # not all of /usr/include, which is for another
                                                                  # processor
  file(CREATE_LINK ${FMT}/fmt ${WORK}/headers/fmt SYMBOLIC)
  set(cross)
  if(PROCESSOR)
    set(cross -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=${PROCESSOR} -DCMAKE_EXE_LINKER_FLAGS=-static)
  endif()
  run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/portable -B ${WORK}/build -G Ninja -DSOURCE=${SOURCE} -DHEADERS=${WORK}/headers
      -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS_RELEASE=-O0 -DNDEBUG" -DCMAKE_CXX_COMPILER=${COMPILER} ${cross})
  run(${CMAKE_COMMAND} --build ${WORK}/build --target portable)
  set(PROGRAM ${WORK}/build/portable)
endif()
if(PROCESSOR AND NOT RUNNER)
  return() # cannot run it: tests only that it builds
endif()
file(READ ${CMAKE_CURRENT_LIST_DIR}/portable/answers.txt known)
foreach(isa IN ITEMS baseline avx2 avx512) # a level that this processor lacks is lowered
  run(${CMAKE_COMMAND} -E env ONCOLLIDE_ISA=${isa} ${RUNNER} ${PROGRAM})
  if(NOT output STREQUAL known)
    message(FATAL_ERROR "with ${isa} the results are\n${output}and not\n${known}")
  endif()
endforeach()
