# Builds and installs the libraries with COMPILER, without the part WITHOUT if given, or with the tools and tests if WHOLE,
# and then uses the installation. COMMAND: with the command, and without all the parts that it can do without.
#   cmake -DSOURCE=project -DWORK=scratch folder -DCOMPILER=c++ [-DWITHOUT=FCL | -DWHOLE=ON | -DCOMMAND=ON] -P variant_test.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)
file(REMOVE_RECURSE ${WORK})
set(parts -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=8)
if(COMMAND)
  list(APPEND parts -DONCOLLIDE_LAB=OFF -DONCOLLIDE_TESTS=OFF -DONCOLLIDE_PYTHON=OFF -DONCOLLIDE_GL=OFF -DONCOLLIDE_FCL=OFF -DONCOLLIDE_OCTOMAP=OFF)
elseif(NOT WHOLE)
  list(APPEND parts -DONCOLLIDE_TOOLS=OFF -DONCOLLIDE_TESTS=OFF -DONCOLLIDE_PYTHON=OFF)
endif()
if(WITHOUT)
  list(APPEND parts -DONCOLLIDE_${WITHOUT}=OFF)
endif()
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -G Ninja -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG"
    -DCMAKE_CXX_COMPILER=${COMPILER} ${parts})
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${CMAKE_COMMAND} --install ${WORK}/build --prefix ${WORK}/prefix)
if(COMMAND)
  set(command ${WORK}/prefix/bin/oncollide)
  run(${command} doctor)
  run(${command} run many --bodies 60 --frames 2)
  foreach(refused IN ITEMS "run;many;--exact;fcl" "run;many;--backend;gl-compute" "render;many;--out;${WORK}/x.png") # one error each
    execute_process(COMMAND ${command} ${refused} RESULT_VARIABLE code ERROR_VARIABLE error OUTPUT_QUIET)
    if(NOT code MATCHES "^(64|71)$" OR NOT error MATCHES "^oncollide: [^\n]*without (FCL|OpenGL)[^\n]*\n$")
      message(FATAL_ERROR "${refused}: code ${code}: ${error}")
    endif()
  endforeach()
  file(REMOVE_RECURSE ${WORK})
  return()
endif()
file(WRITE ${WORK}/user/CMakeLists.txt "cmake_minimum_required(VERSION 3.22)\nproject(user LANGUAGES C CXX)\n"
     "find_package(oncollide REQUIRED)\nadd_executable(user ${CMAKE_CURRENT_LIST_DIR}/variant/main.cpp)\n"
     "target_link_libraries(user oncollide::samples)\n")
run(${CMAKE_COMMAND} -S ${WORK}/user -B ${WORK}/user/build -G Ninja -DCMAKE_PREFIX_PATH=${WORK}/prefix -DCMAKE_CXX_COMPILER=${COMPILER})
run(${CMAKE_COMMAND} --build ${WORK}/user/build)
run(${WORK}/user/build/user "${WITHOUT}")
file(REMOVE_RECURSE ${WORK})
