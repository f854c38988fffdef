# Installs a build to a prefix of its own, then builds and runs the installed example against it with find_package.
#   cmake -DBUILD=build folder -DWORK=scratch folder -DDOC=share/doc/oncollide -DFLAGS=C++ flags -P install_test.cmake
file(REMOVE_RECURSE ${WORK})
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "failed (${code}): ${ARGN}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
run(${CMAKE_COMMAND} -S ${WORK}/prefix/${DOC}/example -B ${WORK}/build -G Ninja -DCMAKE_PREFIX_PATH=${WORK}/prefix
    -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS=${FLAGS}")
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${WORK}/build/two_meshes)
if(NOT output MATCHES "ring and gear are separate" OR NOT output MATCHES "ring and gear are within")
  message(FATAL_ERROR "the example does not find the gear both clear of the ring and touching it:\n${output}")
endif()
run(${WORK}/prefix/bin/oncollide --version)
file(REMOVE_RECURSE ${WORK})
