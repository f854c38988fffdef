# Installs a build to a separate prefix and uses it from there: the example, the programs of README and docs/, every
# header.
#   cmake -DSOURCE=project -DBUILD=its build -DWORK=scratch folder -DDOC=share/doc/oncollide -DFLAGS=C++ flags
#         -DCOMPILER=c++ [-DDART=ON] [-DOMPL=ON] -P install_test.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/pages.cmake)
set(MOST_HEADERS 30) # without the samples; one for robots
file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)

function(build name source compiler) # without optimisation, which would take half of the time
  run(${CMAKE_COMMAND} -S ${source} -B ${WORK}/${name} -G Ninja -DCMAKE_PREFIX_PATH=${WORK}/prefix -DINSTALLED=${WORK}/prefix
      -DCMAKE_CXX_COMPILER=${compiler} "-DCMAKE_CXX_FLAGS=${FLAGS}" ${options})
  run(${CMAKE_COMMAND} --build ${WORK}/${name})
endfunction()

# Both examples; one has the solver of the samples.
build(example ${WORK}/prefix/${DOC}/example ${COMPILER})
run(${WORK}/example/two_meshes)
if(NOT output MATCHES "ring and gear are separate" OR NOT output MATCHES "ring and gear are within")
  message(FATAL_ERROR "the example does not find the gear both clear of the ring and touching it:\n${output}")
endif()
if(EXISTS ${WORK}/prefix/bin/oncollide)
  run(${WORK}/prefix/bin/oncollide --version)
endif()

# The programs and CMake lines of the pages, unchanged.
set(cmake_start "cmake_minimum_required(VERSION 3.22)\nproject(page LANGUAGES C CXX)\n")
blocks(${SOURCE}/README.md cpp program)
blocks(${SOURCE}/README.md cmake lines)
file(WRITE ${WORK}/readme_source/main.cpp "${program}")
file(WRITE ${WORK}/readme_source/CMakeLists.txt "${cmake_start}add_executable(my_program main.cpp)\n${lines}")
build(readme ${WORK}/readme_source ${COMPILER})

# The same program without CMake.
find_program(PKG_CONFIG pkg-config)
if(PKG_CONFIG)
  file(GLOB_RECURSE pc ${WORK}/prefix/oncollide.pc)
  get_filename_component(pc_folder ${pc} DIRECTORY)
  run(${CMAKE_COMMAND} -E env PKG_CONFIG_PATH=${pc_folder} ${PKG_CONFIG} --cflags --libs --static oncollide-samples)
  separate_arguments(pc_flags UNIX_COMMAND "${output}")
  separate_arguments(plain_flags UNIX_COMMAND "${FLAGS}")
  run(${COMPILER} -std=c++20 ${plain_flags} ${WORK}/readme_source/main.cpp ${pc_flags} -o ${WORK}/by_pkg_config)
endif()
if(EXISTS ${WORK}/prefix/bin/oncollide)
  foreach(file IN ITEMS man/man1/oncollide.1 man/man1/oncollide-accuracy-study.1 bash-completion/completions/oncollide
                        zsh/site-functions/_oncollide fish/vendor_completions.d/oncollide.fish
                        man/man1/oncollide-lab-bench-narrow.1 bash-completion/completions/oncollide-lab
                        oncollide/ifc/oncollide-ifc.mjs ../libexec/oncollide/oncollide-ifc)
    if(NOT EXISTS ${WORK}/prefix/share/${file})
      message(FATAL_ERROR "not installed: share/${file}")
    endif()
  endforeach()
endif()

set(page ${SOURCE}/docs/tutorial.md)
blocks(${page} cpp program)
blocks(${page} cmake lines)
file(WRITE ${WORK}/tutorial_source/yard.cpp "${program}")
file(WRITE ${WORK}/tutorial_source/CMakeLists.txt "${lines}")
build(tutorial ${WORK}/tutorial_source ${COMPILER})
run_as_shown(${page} ${WORK}/tutorial/yard)
set(plain "${FLAGS}")
set(FLAGS "${FLAGS} -O1 -march=native") # must not change the layout of types or any result
build(tutorial_native ${WORK}/tutorial_source ${COMPILER})
run_as_shown(${page} ${WORK}/tutorial_native/yard)
set(FLAGS "${plain}")

set(page ${SOURCE}/docs/from/fcl.md)
foreach(library IN ITEMS fcl oncollide)
  set(fence cpp)
  set(target oncollide::oncollide)
  if(library STREQUAL fcl)
    set(fence "cpp fcl")
    set(target fcl)
  endif()
  blocks(${page} "${fence}" program)
  file(WRITE ${WORK}/${library}_source/main.cpp "${program}")
  file(WRITE ${WORK}/${library}_source/CMakeLists.txt "${cmake_start}find_package(${library} REQUIRED)\n"
       "add_executable(tasks main.cpp)\ntarget_link_libraries(tasks PRIVATE ${target})\n")
  build(${library} ${WORK}/${library}_source ${COMPILER})
  run_as_shown(${page} ${WORK}/${library}/tasks)
endforeach()

if(DART) # the detector for DART, built apart
  set(page ${SOURCE}/docs/dart.md)
  set(options -DCMAKE_UNITY_BUILD=ON)
  build(dart_client ${SOURCE}/clients/dart ${COMPILER})
  set(options)
  run(${CMAKE_COMMAND} --install ${WORK}/dart_client --prefix ${WORK}/prefix)
  blocks(${page} cpp program)
  blocks(${page} cmake lines)
  file(WRITE ${WORK}/dart_source/ball.cpp "${program}")
  file(WRITE ${WORK}/dart_source/CMakeLists.txt "${cmake_start}${lines}")
  build(dart ${WORK}/dart_source ${COMPILER})
  run_as_shown(${page} ${WORK}/dart/ball)
  file(REMOVE_RECURSE ${WORK}/prefix/include/oncollide/dart) # below are the headers of oncollide itself
endif()

if(OMPL) # the checkers for OMPL, built apart
  set(page ${SOURCE}/docs/ompl.md)
  build(ompl_client ${SOURCE}/clients/ompl ${COMPILER})
  run(${CMAKE_COMMAND} --install ${WORK}/ompl_client --prefix ${WORK}/prefix)
  blocks(${page} cpp program)
  blocks(${page} xml robot)
  blocks(${page} cmake lines)
  file(WRITE ${WORK}/ompl_source/plan.cpp "${program}")
  file(WRITE ${WORK}/arm.urdf "${robot}")
  file(WRITE ${WORK}/ompl_source/CMakeLists.txt "${cmake_start}${lines}")
  build(ompl ${WORK}/ompl_source ${COMPILER})
  run_as_shown(${page} "${CMAKE_COMMAND};-E;chdir;${WORK};${WORK}/ompl/plan")
  file(REMOVE_RECURSE ${WORK}/prefix/include/oncollide/ompl)
endif()

# Installed headers: few, and none shows locks, atomics, memory maps or internals.
file(GLOB_RECURSE installed RELATIVE ${WORK}/prefix/include/oncollide ${WORK}/prefix/include/oncollide/*.hpp)
list(LENGTH installed count)
if(count GREATER MOST_HEADERS)
  message(FATAL_ERROR "${count} headers are installed, more than ${MOST_HEADERS}:\n${installed}")
endif()
foreach(header IN LISTS installed)
  file(STRINGS ${WORK}/prefix/include/oncollide/${header} shown REGEX "mutex|atomic|mman\\.h|Private")
  if(shown)
    message(FATAL_ERROR "${header} shows internals: ${shown}")
  endif()
endforeach()
build(headers ${CMAKE_CURRENT_LIST_DIR}/headers ${COMPILER})
if(PYTHON AND CMAKE_HOST_SYSTEM_PROCESSOR STREQUAL x86_64)
  run(${PYTHON} ${CMAKE_CURRENT_LIST_DIR}/inline_arithmetic.py ${COMPILER} ${WORK}/prefix/include/oncollide -isystem ${EIGEN}
      -DEIGEN_MAX_STATIC_ALIGN_BYTES=16)
endif()
file(REMOVE_RECURSE ${WORK})
