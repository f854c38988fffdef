# Builds and installs the libraries with COMPILER, without the part WITHOUT if given, or with the tools and tests if WHOLE,
# and then uses the installation.
#   cmake -DSOURCE=project -DWORK=scratch folder -DCOMPILER=c++ [-DWITHOUT=FCL | -DWHOLE=ON] -P variant_test.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)
file(REMOVE_RECURSE ${WORK})
set(parts -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=8)
if(NOT WHOLE)
  list(APPEND parts -DONCOLLIDE_TOOLS=OFF -DONCOLLIDE_TESTS=OFF -DONCOLLIDE_PYTHON=OFF)
endif()
if(WITHOUT)
  list(APPEND parts -DONCOLLIDE_${WITHOUT}=OFF)
endif()
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -G Ninja -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG"
    -DCMAKE_CXX_COMPILER=${COMPILER} ${parts})
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${CMAKE_COMMAND} --install ${WORK}/build --prefix ${WORK}/prefix)
file(WRITE ${WORK}/user/CMakeLists.txt "cmake_minimum_required(VERSION 3.22)\nproject(user LANGUAGES C CXX)\n"
     "find_package(oncollide REQUIRED)\nadd_executable(user ${CMAKE_CURRENT_LIST_DIR}/variant/main.cpp)\n"
     "target_link_libraries(user oncollide::samples)\n")
run(${CMAKE_COMMAND} -S ${WORK}/user -B ${WORK}/user/build -G Ninja -DCMAKE_PREFIX_PATH=${WORK}/prefix -DCMAKE_CXX_COMPILER=${COMPILER})
run(${CMAKE_COMMAND} --build ${WORK}/user/build)
run(${WORK}/user/build/user "${WITHOUT}")
file(REMOVE_RECURSE ${WORK})
