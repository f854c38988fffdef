# Emscripten, with its own toolchain file; em++ must be in PATH.
find_program(ONCOLLIDE_EMXX em++)
if(NOT ONCOLLIDE_EMXX)
  message(FATAL_ERROR "em++ is missing; install emscripten")
endif()
execute_process(COMMAND em-config EMSCRIPTEN_ROOT OUTPUT_VARIABLE emscripten OUTPUT_STRIP_TRAILING_WHITESPACE)
include(${emscripten}/cmake/Modules/Platform/Emscripten.cmake)
# -fgnuc-version: Eigen has assembly of x86 for GCC before 6.3, whose version Clang pretends to have.
# -msse2: Emscripten's headers express SSE2 by vectors of WebAssembly, so that Eigen adds in the same order as on x86-64.
# Exceptions and 128-bit vectors of WebAssembly itself: Chrome 95, Firefox 100, Safari 16.4 and Node.js 17 have both.
string(APPEND CMAKE_C_FLAGS_INIT " -fwasm-exceptions -sSUPPORT_LONGJMP=wasm")
string(APPEND CMAKE_CXX_FLAGS_INIT " -fwasm-exceptions -msimd128 -msse2 -fgnuc-version=7.0 -isystem ${CMAKE_CURRENT_LIST_DIR}/sse2 -include ${CMAKE_CURRENT_LIST_DIR}/libcxx13/missing.hpp")
string(APPEND CMAKE_EXE_LINKER_FLAGS_INIT " -fwasm-exceptions -sSUPPORT_LONGJMP=wasm -sALLOW_MEMORY_GROWTH=1 -sMAXIMUM_MEMORY=4GB -sTOTAL_STACK=4MB")
# Its programs call fetch() on a file's path, where Node.js has fetch().
set(CMAKE_CROSSCOMPILING_EMULATOR node --no-experimental-fetch)
# Its optimiser loads acorn, which only Debian's own Node.js finds at Debian's place.
set_property(GLOBAL PROPERTY RULE_LAUNCH_LINK "${CMAKE_COMMAND} -E env NODE_PATH=/usr/share/nodejs:$ENV{NODE_PATH}")
# Clang 14 loses the order of a load into all lanes and of later stores.
find_program(ONCOLLIDE_PYTHON3 python3 PATHS /usr/bin NO_DEFAULT_PATH REQUIRED)
set(CMAKE_CXX_COMPILER_LAUNCHER ${ONCOLLIDE_PYTHON3} ${CMAKE_CURRENT_LIST_DIR}/no_load_splat.py)
