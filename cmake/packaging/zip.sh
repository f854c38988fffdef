#!/bin/bash
# Packs the command and the library for Windows as BUILD/packages/oncollide-VERSION-windows-x86_64.zip, and tests the archive
# under Wine as a user would: unpacked in a folder with a foreign name, and with a program that uses the library.
# usage: zip.sh BUILD
set -euo pipefail
here=$(dirname "$(readlink -f "$0")")
build=$(readlink -f "$1")
version=$(sed -n 's/^CMAKE_PROJECT_VERSION:STATIC=//p' "$build/CMakeCache.txt")
name=oncollide-$version-windows-x86_64
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for component in command headers windows; do
    cmake --install "$build" --prefix "$work/$name" --component $component --strip >/dev/null
done
[[ -f $work/$name/lib/liboncollide.a && -f $work/$name/bin/oncollide.exe ]] || { echo "zip.sh: build oncollide_whole and oncollide_tool first" >&2; exit 1; }
mkdir -p "$build/packages"
zip=$build/packages/$name.zip
rm -f "$zip"
( cd "$work" && cmake -E tar cf "$zip" --format=zip "$name" )

# The test begins here: a user unpacks the archive.
place=$work/'größe 漢'
mkdir "$place"
( cd "$place" && cmake -E tar xf "$zip" )
cd "$place"
wine=("$here/../toolchains/wine.sh" "$build/wine")
/usr/bin/python3 "$here/../../tests/builds/command_hashes.py" "${wine[@]}" "$PWD/$name/bin/oncollide.exe"
# Every DLL is a part of Windows.
foreign=$(x86_64-w64-mingw32-objdump -p "$name/bin/oncollide.exe" | sed -n 's/.*DLL Name: //p' | grep -viE '^(kernel32|advapi32|msvcrt|user32|shell32|api-ms-win-[a-z0-9-]*)\.dll$' || true)
[[ -z $foreign ]] || { echo "zip.sh: oncollide.exe needs $foreign" >&2; exit 1; }

mkdir program
# The ball through a ring of README.md.
sed -n '/^A ball flies through a ring:/,/^```$/p' "$here/../../README.md" | sed -e '1,/^```cpp$/d' -e '/^```$/d' >program/main.cpp
cat >program/CMakeLists.txt <<'TEXT'
cmake_minimum_required(VERSION 3.22)
project(program CXX)
find_package(oncollide REQUIRED)
add_executable(program main.cpp)
target_link_libraries(program PRIVATE oncollide::samples)
TEXT
printf 'list(APPEND CMAKE_FIND_ROOT_PATH "%s" /usr/share/eigen3)\n' "$PWD/$name" | cat "$here/../toolchains/windows.cmake" - >toolchain.cmake
cmake -G Ninja -S program -B program/build -DCMAKE_TOOLCHAIN_FILE="$PWD/toolchain.cmake" -DCMAKE_BUILD_TYPE=Release \
    -DEigen3_DIR=/usr/share/eigen3/cmake >log && cmake --build program/build >>log || { cat log >&2; exit 1; }
"${wine[@]}" program/build/program.exe >output
tr -d '\r' <output | diff "$here/windows/ring.txt" - || { echo "zip.sh: the program of README.md prints something else" >&2; exit 1; }
printf '%s: %d bytes; oncollide.exe %d\n' "$zip" "$(stat -c %s "$zip")" "$(stat -c %s "$name/bin/oncollide.exe")"
