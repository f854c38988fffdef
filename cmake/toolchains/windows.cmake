# MinGW-w64 for 64-bit Windows, with threads of POSIX; tests and programs run under Wine.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc-posix)
set(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++-posix)
set(CMAKE_RC_COMPILER x86_64-w64-mingw32-windres)
set(CMAKE_FIND_ROOT_PATH /usr/x86_64-w64-mingw32)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
foreach(kind IN ITEMS LIBRARY INCLUDE PACKAGE)
  set(CMAKE_FIND_ROOT_PATH_MODE_${kind} ONLY)
endforeach()
# Windows aligns the stack to 16 bytes, and GCC writes 32-byte registers there as if it were aligned to 32 (GCC bug 54412).
set(unaligned "-Wa,-muse-unaligned-vector-move")
# NOMINMAX: <windows.h> has macros min and max. 0x0A00: Windows 10.
string(APPEND CMAKE_CXX_FLAGS_INIT " ${unaligned} -DNOMINMAX -DWIN32_LEAN_AND_MEAN -D_WIN32_WINNT=0x0A00")
# Programs need no DLL of the compiler.
string(APPEND CMAKE_EXE_LINKER_FLAGS_INIT " -static")
set(CMAKE_CROSSCOMPILING_EMULATOR ${CMAKE_CURRENT_LIST_DIR}/wine.sh ${CMAKE_BINARY_DIR}/wine)
