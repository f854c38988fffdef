#!/bin/sh
# Runs ../lib/@program@/@program@ with the bundled libraries. Needs glibc 2.@needed@; uses the bundled C library if the
# system's is older or missing (or ONCOLLIDE_LIBC=bundled).
root=$(dirname "$(readlink -f "$0")")/..
home=$root/lib/@program@
if [ -z "$ONCOLLIDE_THREE" ] && [ -d "$root/share/@program@/three" ]; then
    export ONCOLLIDE_THREE="$root/share/@program@/three" # three.js for pages (run --view)
fi
if [ -d "$home/gl" ]; then
    export ONCOLLIDE_GL_LIBRARIES="$home/gl" # used if the system has no loaders
    if [ -z "$__EGL_VENDOR_LIBRARY_FILENAMES$__EGL_VENDOR_LIBRARY_DIRS" ]; then
        export __EGL_VENDOR_LIBRARY_DIRS="/etc/glvnd/egl_vendor.d:/usr/share/glvnd/egl_vendor.d:$home/gl/vendors"
    fi
fi
version=$(getconf GNU_LIBC_VERSION 2>/dev/null)
minor=${version#glibc 2.}
case $minor in '' | *[!0-9]*) minor=0 ;; esac
if [ "$minor" -ge @needed@ ] && [ "$ONCOLLIDE_LIBC" != bundled ]; then
    exec "$home/@program@" "$@"
fi
exec "$home/libc/@loader@" --library-path "$home/libc:$home" --argv0 "$0" "$home/@program@" "$@"
