# Installs a build to a prefix of its own and uses it from there: the example, README's snippets, every header.
#   cmake -DSOURCE=project -DBUILD=its build -DWORK=scratch folder -DDOC=share/doc/oncollide -DFLAGS=C++ flags
#         -DCOMPILER=c++ [-DCLANG=clang++] -P install_test.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)
file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)

function(build name source compiler)
  run(${CMAKE_COMMAND} -S ${source} -B ${WORK}/${name} -G Ninja -DCMAKE_PREFIX_PATH=${WORK}/prefix -DINSTALLED=${WORK}/prefix
      -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER=${compiler} "-DCMAKE_CXX_FLAGS=${FLAGS}")
  run(${CMAKE_COMMAND} --build ${WORK}/${name})
endfunction()

build(example ${WORK}/prefix/${DOC}/example ${COMPILER})
run(${WORK}/example/two_meshes)
if(NOT output MATCHES "ring and gear are separate" OR NOT output MATCHES "ring and gear are within")
  message(FATAL_ERROR "the example does not find the gear both clear of the ring and touching it:\n${output}")
endif()
if(EXISTS ${WORK}/prefix/bin/oncollide)
  run(${WORK}/prefix/bin/oncollide --version)
endif()

# README's program and its lines for CMake, as they stand.
file(READ ${SOURCE}/README.md readme)
foreach(language IN ITEMS cpp cmake)
  string(REGEX MATCH "```${language}\n([^`]*)```" block "${readme}")
  set(${language} "${CMAKE_MATCH_1}")
endforeach()
file(WRITE ${WORK}/readme_source/main.cpp "${cpp}")
file(WRITE ${WORK}/readme_source/CMakeLists.txt
     "cmake_minimum_required(VERSION 3.22)\nproject(readme LANGUAGES C CXX)\nadd_executable(my_program main.cpp)\n${cmake}")
build(readme ${WORK}/readme_source ${COMPILER})

build(headers ${CMAKE_CURRENT_LIST_DIR}/headers ${COMPILER})
if(CLANG)
  set(FLAGS)
  build(headers_clang ${CMAKE_CURRENT_LIST_DIR}/headers ${CLANG})
endif()
file(REMOVE_RECURSE ${WORK})
