# Installs the shared library of a build without its static libraries, and uses it from there.
#   cmake -DSOURCE=project -DBUILD=its build -DWORK=scratch folder -DFLAGS=C++ flags -DCOMPILER=c++ -DPYTHON=python3
#         -P shared_test.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/pages.cmake)
set(MOST_EXPORTS 370) # 32 of them for robots, 34 for motions and manifolds
file(REMOVE_RECURSE ${WORK})
foreach(component IN ITEMS headers shared)
  run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix --component ${component})
endforeach()
file(GLOB_RECURSE archives ${WORK}/prefix/*.a)
file(GLOB_RECURSE library ${WORK}/prefix/liboncollide.so)
if(archives OR NOT library)
  message(FATAL_ERROR "the shared variant installs archives (${archives}), or no library (${library})")
endif()
if(PYTHON AND NOT FLAGS MATCHES -fsanitize) # sanitizers export names of their own
  run(${PYTHON} ${CMAKE_CURRENT_LIST_DIR}/exports.py ${library} ${WORK}/prefix/include ${MOST_EXPORTS})
endif()

# The program of the README, as it is for the static libraries.
blocks(${SOURCE}/README.md cpp program)
blocks(${SOURCE}/README.md cmake lines)
file(WRITE ${WORK}/readme_source/main.cpp "${program}")
file(WRITE ${WORK}/readme_source/CMakeLists.txt
     "cmake_minimum_required(VERSION 3.22)\nproject(page LANGUAGES CXX)\nadd_executable(my_program main.cpp)\n${lines}")
run(${CMAKE_COMMAND} -S ${WORK}/readme_source -B ${WORK}/readme -G Ninja -DCMAKE_PREFIX_PATH=${WORK}/prefix
    -DCMAKE_CXX_COMPILER=${COMPILER} "-DCMAKE_CXX_FLAGS=${FLAGS}")
run(${CMAKE_COMMAND} --build ${WORK}/readme)
run(${WORK}/readme/my_program)
if(NOT output MATCHES "frame [0-9]+: within" OR NOT output MATCHES "frame [0-9]+: separate")
  message(FATAL_ERROR "the ball does not fly through the ring:\n${output}")
endif()

# Another one without CMake.
find_program(PKG_CONFIG pkg-config)
if(PKG_CONFIG)
  get_filename_component(folder ${library} DIRECTORY)
  run(${CMAKE_COMMAND} -E env PKG_CONFIG_PATH=${folder}/pkgconfig ${PKG_CONFIG} --cflags --libs oncollide-samples)
  separate_arguments(pc_flags UNIX_COMMAND "${output}")
  separate_arguments(plain_flags UNIX_COMMAND "${FLAGS}")
  run(${COMPILER} -std=c++20 ${plain_flags} ${CMAKE_CURRENT_LIST_DIR}/shared/main.cpp ${pc_flags} -Wl,-rpath,${folder} -o ${WORK}/main)
  run(${WORK}/main)
endif()

# BUILD_SHARED_LIBS makes this variant the one that is built and installed. Configured only: it is compiled as here.
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -G Ninja -DBUILD_SHARED_LIBS=ON -DONCOLLIDE_TOOLS=OFF -DONCOLLIDE_TESTS=OFF
    -DONCOLLIDE_PYTHON=OFF -DCMAKE_CXX_COMPILER=${COMPILER})
run(${CMAKE_COMMAND} --build ${WORK}/build -- -n)
if(NOT output MATCHES "Linking CXX shared library liboncollide\\.so")
  message(FATAL_ERROR "with BUILD_SHARED_LIBS=ON the library is not part of the build:\n${output}")
endif()
file(REMOVE_RECURSE ${WORK})
