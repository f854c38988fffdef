#!/bin/sh
# Runs a program of Windows under Wine: wine.sh FOLDER PROGRAM ARGUMENTS
# FOLDER: for Wine's settings and disks; made at first use
wine=/usr/lib/wine/wine64 # Debian's package has no link in PATH
[ -x "$wine" ] || wine=wine
mkdir -p "$1"
export WINEPREFIX="$1" WINEDEBUG=-all WINEDLLOVERRIDES='mscoree=;mshtml=' LC_ALL=C.UTF-8
shift
# All programs of a folder share a server and services. If the first program started them, they would hold that program's output
# open until the last one ends, and a test would seem to run for as long.
"$wine" wineboot </dev/null >/dev/null 2>&1
exec "$wine" "$@"
