#!/bin/sh
# Runs a program of Windows under Wine: wine.sh FOLDER PROGRAM ARGUMENTS
# FOLDER: for Wine's settings and disks; made at first use
wine=/usr/lib/wine/wine64 # Debian's package wine64 has no link in PATH
[ -x "$wine" ] || wine=wine
export WINEPREFIX="$1" WINEDEBUG=-all WINEDLLOVERRIDES='mscoree=;mshtml=' LC_ALL=C.UTF-8
shift
exec "$wine" "$@"
