# One function; one target per folder.
#
#   oncollide_add_module(broadphase
#       HEADERS kd_tree.hpp ...      public, installed, each compiled alone by the tests
#       SOURCES kd_tree.cpp ...
#       DEPENDS geometry             lower modules only
#       LINK    Qhull::qhull_r)      private third-party libraries
#   SAMPLES: a part of oncollide::samples; only its users see the headers
#   FOLDER: where its headers are, if not in the folder of its name
#
# A module can include its own headers and the headers of modules that it depends on, as <oncollide/MODULE/x.hpp>, and
# no others: the module's headers are linked into an include tree of their own, cmake/include/MODULE, so an upward include
# does not compile, and an editor follows every include in a fresh clone (compile_flags.txt). Three modules share the folder
# scenes/: each tree links a part of it. The two modules of samples/ share one tree.

set(ONCOLLIDE_SAMPLES_INCLUDE ${CMAKE_INSTALL_INCLUDEDIR}/oncollide-samples)
# Bottom first. Only catalogue and robots depend on files.
set(ONCOLLIDE_LAYERS base geometry broadphase narrowphase pipeline scenes generators files catalogue robots runs)

# Eigen aligns its types for the processor's widest registers, so a program compiled with -march=native would use other
# structure layouts. All users of the library get the baseline's alignment.
set(ONCOLLIDE_EIGEN_LAYOUT EIGEN_MAX_STATIC_ALIGN_BYTES=16)

# Modules are static libraries. The shared library (BUILD_SHARED_LIBS) is linked from the same objects: position-independent,
# with hidden visibility except for ONCOLLIDE_API. All other targets share precompiled headers with the modules, so their
# visibility is hidden, too. Each variant's files are an install component, static or shared, besides the component
# headers: a build of one variant can install the other (`cmake --install DIR --component shared`).
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
set(ONCOLLIDE_STATIC COMPONENT static)
set(ONCOLLIDE_SHARED COMPONENT shared EXCLUDE_FROM_ALL)
if(BUILD_SHARED_LIBS)
  set(ONCOLLIDE_STATIC COMPONENT static EXCLUDE_FROM_ALL)
  set(ONCOLLIDE_SHARED COMPONENT shared)
endif()

# WebAssembly has no shared libraries here, and position-independent code would be slower.
set(ONCOLLIDE_SHAREABLE ON)
if(EMSCRIPTEN)
  set(ONCOLLIDE_SHAREABLE OFF)
endif()

add_library(oncollide_flags INTERFACE)
target_compile_definitions(oncollide_flags INTERFACE ${ONCOLLIDE_EIGEN_LAYOUT})
target_compile_features(oncollide_flags INTERFACE cxx_std_20)
if(NOT ONCOLLIDE_DEMO) # the demo builds faster without warnings; in large units -Wshadow would warn of names of other files
  set(shadow -Wshadow)
  if(ONCOLLIDE_CROSS) # other compilers warn of names of other files in small units, too
    set(shadow)
  endif()
  target_compile_options(oncollide_flags INTERFACE -Wall -Wextra -Wpedantic $<$<NOT:$<BOOL:$<TARGET_PROPERTY:ONCOLLIDE_LARGE_UNITS>>>:${shadow}>)
endif()
target_compile_options(oncollide_flags INTERFACE "$<$<CXX_COMPILER_ID:Clang>:-Wno-nested-anon-types;-Wno-bitwise-instead-of-logical;-Wno-unused-private-field>")
# No contraction: every path and every optimisation level must compute the same bits. No straight-line vectoriser: GCC
# 12's omits the rounding of double -> float -> double, on which the bounds rely.
target_compile_options(oncollide_flags INTERFACE -ffp-contract=off -fno-tree-slp-vectorize
                       $<$<CONFIG:Debug>:-DONCOLLIDE_ASSERTIONS>)
# GCC collects garbage less often: a large unit takes about a fifth more memory, and 6 % less time.
target_compile_options(oncollide_flags INTERFACE
  "$<$<AND:$<CXX_COMPILER_ID:GNU>,$<BOOL:${CMAKE_UNITY_BUILD}>>:--param=ggc-min-expand=300;--param=ggc-min-heapsize=1500000>")

# Precompiles the headers that nearly every unit includes: Eigen alone takes three seconds. A header must not depend on
# them: public headers are compiled alone, without precompiled headers. -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON turns them
# off.
function(oncollide_precompile target)
  target_precompile_headers(${target} PRIVATE
    <algorithm> <array> <atomic> <bit> <chrono> <cmath> <cstdint> <cstring> <filesystem> <functional> <iosfwd> <limits> <map> <memory>
    <mutex> <numeric> <optional> <span> <string> <string_view> <unordered_map> <utility> <variant> <vector>
    <Eigen/Geometry> <fmt/format.h> ${ARGN})
endfunction()
if(TARGET nlohmann_json::nlohmann_json) # tests/builds/portable has no modules
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/precompiled.cpp CONTENT "")
  add_library(oncollide_precompiled OBJECT ${PROJECT_BINARY_DIR}/precompiled.cpp) # for the modules; compiled with their
                                                                                  # flags
  set_target_properties(oncollide_precompiled PROPERTIES POSITION_INDEPENDENT_CODE ${ONCOLLIDE_SHAREABLE})
  target_link_libraries(oncollide_precompiled PRIVATE oncollide_flags Eigen3::Eigen fmt::fmt nlohmann_json::nlohmann_json)
  oncollide_precompile(oncollide_precompiled <nlohmann/json.hpp>)
endif()

function(oncollide_add_module name)
  cmake_parse_arguments(arg "SAMPLES" "FOLDER" "HEADERS;SOURCES;DEPENDS;LINK" ${ARGN})
  set(include ${CMAKE_INSTALL_INCLUDEDIR})
  if(arg_SAMPLES)
    set(include ${ONCOLLIDE_SAMPLES_INCLUDE})
  endif()
  if(NOT arg_FOLDER)
    set(arg_FOLDER ${name})
  endif()
  list(FIND ONCOLLIDE_LAYERS ${name} layer)
  foreach(dependency IN LISTS arg_DEPENDS)
    list(FIND ONCOLLIDE_LAYERS ${dependency} below)
    if(NOT below LESS layer)
      message(FATAL_ERROR "${name} may not depend on ${dependency}: dependencies point down only (${ONCOLLIDE_LAYERS})")
    endif()
  endforeach()

  set(include_tree ${PROJECT_SOURCE_DIR}/cmake/include/${name}) # exposes only this module
  if(NOT EXISTS ${include_tree})
    set(include_tree ${PROJECT_SOURCE_DIR}/cmake/include/${arg_FOLDER})
  endif()

  add_library(oncollide_${name} STATIC ${arg_SOURCES})
  add_library(oncollide::${name} ALIAS oncollide_${name})
  set_target_properties(oncollide_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ${ONCOLLIDE_SHAREABLE})
  target_compile_features(oncollide_${name} PUBLIC cxx_std_20)
  target_compile_definitions(oncollide_${name} INTERFACE ${ONCOLLIDE_EIGEN_LAYOUT})
  target_include_directories(oncollide_${name} PUBLIC
    $<BUILD_INTERFACE:${include_tree}> $<INSTALL_INTERFACE:${include}>)
  target_link_libraries(oncollide_${name} PUBLIC Eigen3::Eigen
    PRIVATE $<BUILD_INTERFACE:oncollide_flags> ${arg_LINK})
  foreach(dependency IN LISTS arg_DEPENDS)
    target_link_libraries(oncollide_${name} PUBLIC oncollide_${dependency})
  endforeach()

  if(NOT name STREQUAL base) # few files of base use Eigen
    target_link_libraries(oncollide_${name} PRIVATE fmt::fmt) # its definitions must be the same as in the precompiled
                                                              # headers
    target_precompile_headers(oncollide_${name} REUSE_FROM oncollide_precompiled)
  endif()

  install(TARGETS oncollide_${name} EXPORT oncollide ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} ${ONCOLLIDE_STATIC})
  foreach(header IN LISTS arg_HEADERS)
    if(NOT arg_SAMPLES)
      set_property(GLOBAL APPEND PROPERTY ONCOLLIDE_PUBLIC_HEADERS ${CMAKE_CURRENT_SOURCE_DIR}/${header})
    endif()
    get_filename_component(folder ${header} DIRECTORY)
    install(FILES ${header} DESTINATION ${include}/oncollide/${arg_FOLDER}/${folder} COMPONENT headers)
  endforeach()
endfunction()

# Sources that each operating system has for itself: FOLDER/NAME.cpp, or FOLDER/windows/NAME.cpp. A source of Windows is a
# unit of its own, because <windows.h> has macros such as `near` and `far`.
function(oncollide_add_system_sources target)
  foreach(source IN LISTS ARGN)
    if(WIN32)
      get_filename_component(folder ${source} DIRECTORY)
      get_filename_component(name ${source} NAME)
      set(source ${folder}/windows/${name})
      set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    endif()
    target_sources(${target} PRIVATE ${source})
  endforeach()
endfunction()

# A part of a module that ONCOLLIDE_<PART>=OFF leaves out: ABSENT then replaces SOURCES, with the same functions.
function(oncollide_add_part module part)
  cmake_parse_arguments(arg "" "" "SOURCES;ABSENT;LINK" ${ARGN})
  if(ONCOLLIDE_${part})
    target_sources(oncollide_${module} PRIVATE ${arg_SOURCES})
    target_link_libraries(oncollide_${module} PRIVATE ${arg_LINK})
  else()
    target_sources(oncollide_${module} PRIVATE ${arg_ABSENT})
  endif()
endfunction()

# Compiles sources whose numbers are all doubles as one unit with the straight-line vectoriser, which has no rounding to
# float there that it could omit: GJK takes 0.55 to 0.6 of the time.
function(oncollide_add_vectorised target)
  set(includes)
  foreach(source IN LISTS ARGN)
    get_filename_component(source ${source} ABSOLUTE)
    file(STRINGS ${source} floats REGEX "float|F32")
    if(floats)
      message(FATAL_ERROR "${source} computes with floats: oncollide_add_vectorised is for sources without floats")
    endif()
    string(APPEND includes "#include \"${source}\"\n")
    list(APPEND sources ${source})
  endforeach()
  set(unit ${CMAKE_CURRENT_BINARY_DIR}/vectorised.cpp)
  file(CONFIGURE OUTPUT ${unit} CONTENT "${includes}")
  set_source_files_properties(${unit} PROPERTIES COMPILE_OPTIONS -ftree-slp-vectorize OBJECT_DEPENDS "${sources}"
                              SKIP_UNITY_BUILD_INCLUSION ON SKIP_PRECOMPILE_HEADERS ON)
  target_sources(${target} PRIVATE ${unit})
endfunction()

# Compiles KERNEL once per instruction set: oncollide_add_kernel(TARGET kernel.cpp) builds it with ONCOLLIDE_ISA set to
# baseline and, on x86-64, avx2 and avx512; WITHOUT avx512 if that gains too little. The kernel puts all its definitions
# in namespace ONCOLLIDE_ISA and shares no inline function with the rest of the program: the linker must never use AVX
# code for functions that run on a machine without AVX.
set(ONCOLLIDE_ISAS baseline)
set(ONCOLLIDE_ISA_FLAGS_baseline)
if(ONCOLLIDE_DEMO)
  target_compile_definitions(oncollide_flags INTERFACE ONCOLLIDE_BASELINE_ALONE)
elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64)$")
  list(APPEND ONCOLLIDE_ISAS avx2 avx512)
endif()
set(ONCOLLIDE_ISA_FLAGS_avx2 -mavx2 -mbmi -mbmi2 -mpopcnt)
set(ONCOLLIDE_ISA_FLAGS_avx512 ${ONCOLLIDE_ISA_FLAGS_avx2} -mavx512f -mavx512vl -mavx512bw -mavx512dq)
function(oncollide_add_kernel target source)
  cmake_parse_arguments(arg "" "" WITHOUT ${ARGN})
  set(isas ${ONCOLLIDE_ISAS})
  if(arg_WITHOUT)
    list(REMOVE_ITEM isas ${arg_WITHOUT})
  endif()
  get_filename_component(source ${source} ABSOLUTE)
  foreach(isa IN LISTS isas)
    get_filename_component(stem ${source} NAME_WE)
    set(unit ${CMAKE_CURRENT_BINARY_DIR}/${stem}_${isa}.cpp)
    file(CONFIGURE OUTPUT ${unit} CONTENT "#define ONCOLLIDE_ISA ${isa}\n#include \"${source}\"\n")
    set_source_files_properties(${unit} PROPERTIES COMPILE_OPTIONS "-O2;-falign-functions=64;-Wno-psabi;${ONCOLLIDE_ISA_FLAGS_${isa}}"
                                OBJECT_DEPENDS ${source} SKIP_PRECOMPILE_HEADERS ON)
    target_sources(${target} PRIVATE ${unit})
  endforeach()
endfunction()
