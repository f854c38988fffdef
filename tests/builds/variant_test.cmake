# Builds and installs the libraries with COMPILER, without the part OFF if given, or with the tools and tests if WHOLE,
# and then uses the installation.
#   cmake -DSOURCE=project -DWORK=scratch folder -DCOMPILER=c++ [-DOFF=FCL | -DWHOLE=ON] -P variant_test.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)
file(REMOVE_RECURSE ${WORK})
set(parts -DONCOLLIDE_TOOLS=OFF -DONCOLLIDE_TESTS=OFF)
if(WHOLE)
  set(parts -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=8)
elseif(OFF)
  list(APPEND parts -DONCOLLIDE_${OFF}=OFF)
endif()
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -G Ninja -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG"
    -DCMAKE_CXX_COMPILER=${COMPILER} ${parts})
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${CMAKE_COMMAND} --install ${WORK}/build --prefix ${WORK}/prefix)
file(WRITE ${WORK}/user/CMakeLists.txt "cmake_minimum_required(VERSION 3.22)\nproject(user LANGUAGES C CXX)\n"
     "find_package(oncollide REQUIRED)\nadd_executable(user main.cpp)\ntarget_link_libraries(user oncollide::oncollide)\n")
file(WRITE ${WORK}/user/main.cpp "#include <oncollide/base/executor.hpp>\nint main() { return oncollide::thread_pool().threads() < 1; }\n")
run(${CMAKE_COMMAND} -S ${WORK}/user -B ${WORK}/user/build -G Ninja -DCMAKE_PREFIX_PATH=${WORK}/prefix -DCMAKE_CXX_COMPILER=${COMPILER})
run(${CMAKE_COMMAND} --build ${WORK}/user/build)
run(${WORK}/user/build/user)
file(REMOVE_RECURSE ${WORK})
