# Compiles all sources for Windows and the public headers by MinGW-w64, without the rest of the library.
file(MAKE_DIRECTORY ${WORK}/headers)
file(CREATE_LINK /usr/include/fmt ${WORK}/headers/fmt SYMBOLIC) # the rest of /usr/include is for this machine
file(WRITE ${WORK}/standard.cpp "#include <oncollide/oncollide.hpp>\n")
file(GLOB include_trees ${SOURCE}/cmake/include/*)
list(TRANSFORM include_trees PREPEND -I)
file(GLOB halves ${SOURCE}/base/*/windows/*.cpp ${SOURCE}/runs/ranks/windows/*.cpp ${SOURCE}/tools/command/cli/windows/*.cpp)
foreach(unit IN LISTS halves ITEMS ${WORK}/standard.cpp)
  execute_process(COMMAND_ERROR_IS_FATAL ANY COMMAND ${COMPILER} -std=c++20 -fsyntax-only -Wall -Wextra -Wpedantic -Werror -DFMT_HEADER_ONLY
    -DNOMINMAX -DWIN32_LEAN_AND_MEAN -D_WIN32_WINNT=0x0A00 -DEIGEN_MAX_STATIC_ALIGN_BYTES=16 ${include_trees} -I${SOURCE}/tools/command
    -isystem ${WORK}/headers -isystem ${EIGEN} ${unit})
endforeach()
list(LENGTH halves count)
if(count LESS 6)
  message(FATAL_ERROR "only ${count} sources are found")
endif()
