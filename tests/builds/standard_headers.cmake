# Other compilers, too, read the public headers: they hold no extension of GNU, and give no warning.
file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/standard.cpp CONTENT "#include <oncollide/oncollide.hpp>\n")
file(GLOB include_trees ${PROJECT_SOURCE_DIR}/cmake/include/*)
list(TRANSFORM include_trees PREPEND -I)
get_target_property(eigen Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
function(oncollide_add_headers_test name compiler)
  add_test(NAME headers.${name}
    COMMAND ${compiler} -std=c++20 -pedantic-errors -Wall -Wextra -Wshadow -Wconversion -Werror -fsyntax-only
            -D${ONCOLLIDE_EIGEN_LAYOUT} ${include_trees} -isystem ${eigen} ${CMAKE_CURRENT_BINARY_DIR}/standard.cpp)
endfunction()
if(NOT EMSCRIPTEN)
  oncollide_add_headers_test(AreStandardCpp ${CMAKE_CXX_COMPILER})
endif()
find_program(ONCOLLIDE_CLANG clang++)
mark_as_advanced(ONCOLLIDE_CLANG)
if(ONCOLLIDE_CLANG AND NOT CMAKE_CROSSCOMPILING)
  oncollide_add_headers_test(AreStandardCppForClang ${ONCOLLIDE_CLANG})
endif()
if(Python3_EXECUTABLE)
  get_property(headers GLOBAL PROPERTY ONCOLLIDE_PUBLIC_HEADERS)
  add_test(NAME headers.HoldNoExtensionOfGnu
    COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/standard_headers.py ${headers})
endif()
