# For a system whose other libraries Debian does not have: WebAssembly. Libraries that are headers alone are taken from this
# machine; they are linked into a folder of their own, because the rest of /usr/include is for this machine. Qhull is compiled
# from its source: ./dev unpacks Debian's in build/qhull; -DONCOLLIDE_QHULL= names another one.
set(ONCOLLIDE_HOST_INCLUDE /usr/include CACHE PATH "Has the headers fmt/, nlohmann/, eigen3/ and, for tests, boost/")
set(headers ${PROJECT_BINARY_DIR}/headers)
file(MAKE_DIRECTORY ${headers})
foreach(name IN ITEMS fmt nlohmann boost eigen3/Eigen)
  if(EXISTS ${ONCOLLIDE_HOST_INCLUDE}/${name})
    get_filename_component(link ${name} NAME)
    file(CREATE_LINK ${ONCOLLIDE_HOST_INCLUDE}/${name} ${headers}/${link} SYMBOLIC)
  elseif(NOT name STREQUAL boost)
    message(FATAL_ERROR "${ONCOLLIDE_HOST_INCLUDE}/${name} is missing; install libfmt-dev, nlohmann-json3-dev and libeigen3-dev, "
                        "or set ONCOLLIDE_HOST_INCLUDE")
  endif()
endforeach()
foreach(library IN ITEMS Eigen3::Eigen fmt::fmt nlohmann_json::nlohmann_json)
  add_library(${library} INTERFACE IMPORTED GLOBAL)
  target_include_directories(${library} SYSTEM INTERFACE ${headers})
endforeach()
target_compile_definitions(fmt::fmt INTERFACE FMT_HEADER_ONLY)

file(GLOB unpacked ${PROJECT_SOURCE_DIR}/build/qhull/qhull-*)
set(ONCOLLIDE_QHULL "${unpacked}" CACHE PATH "Source of Qhull 2020.2")
if(NOT EXISTS ${ONCOLLIDE_QHULL}/src/libqhull_r/libqhull_r.c)
  message(FATAL_ERROR "the source of Qhull is missing; './dev build --preset ...' unpacks it, or set ONCOLLIDE_QHULL")
endif()
file(GLOB qhull_sources ${ONCOLLIDE_QHULL}/src/libqhull_r/*_r.c)
list(FILTER qhull_sources EXCLUDE REGEX "rbox")
add_library(oncollide_qhull STATIC ${qhull_sources})
target_include_directories(oncollide_qhull SYSTEM INTERFACE ${ONCOLLIDE_QHULL}/src)
set_target_properties(oncollide_qhull PROPERTIES UNITY_BUILD OFF C_VISIBILITY_PRESET hidden)
target_compile_definitions(oncollide_qhull PRIVATE qh_NOtrace) # messages for its own development, a third of its code
target_compile_options(oncollide_qhull PRIVATE -ffp-contract=off $<$<BOOL:${EMSCRIPTEN}>:-Os>)
add_library(Qhull::qhull_r ALIAS oncollide_qhull)
