#!/bin/bash
# Tests the packages of a folder in bare root file systems: try.sh FOLDER. Needs root, debootstrap and Debian's archive;
# otherwise prints that it is skipped.
#   1. the archive in Debian's smallest system, in several folders, with the system's C library and with the bundled one
#   2. the archive in a root that has only a shell (busybox): no library of the system at all
#   3. the .deb in Debian's smallest system: it brings no library that only oncollide-lab compares with
#   4. the .deb of oncollide-lab, which brings them
set -euo pipefail
packages=$(readlink -f "$1")
archive=$(ls "$packages"/oncollide-[0-9]*.tar.gz) deb=$(ls "$packages"/oncollide_*.deb) lab=$(ls "$packages"/oncollide-lab_*.deb)
mirror=${MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Codename: bookworm' | head -n 1)}
[[ $mirror || ${BARE:-} ]] || { echo "try: skipped: no mirror of Debian 12 in apt or in MIRROR" >&2; exit 0; }
(( EUID == 0 )) && command -v debootstrap >/dev/null || { echo "try: skipped: needs root and debootstrap" >&2; exit 0; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

bare=${BARE:-$work/bare}
[[ -d $bare/usr ]] || debootstrap --variant=minbase bookworm "$bare" "$mirror" >"$work/log" || { tail "$work/log" >&2; exit 1; }

cube='OFF\n8 12 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n3 0 2 1\n3 0 3 2\n3 4 5 6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n'
# In the root $1: the command $2 prints its version, finds a collision (exit code 1), runs a scene, writes a page if
# three.js is bundled ($3: 0; 66 otherwise), and reports whether it can draw a picture.
works_in() {
    local root=$1 command=$2 page=$3
    printf "$cube" >"$root/tmp/cube.off"
    chroot "$root" /bin/sh -euc "
        $command --version | grep -q '^oncollide '
        code=0; $command check /tmp/cube.off /tmp/cube.off --pose-b '0.5 0 0 0 0 0 1' --quiet || code=\$?; [ \$code = 1 ]
        $command run many --bodies 50 --frames 3 --exact on --quiet --json /tmp/r.json; [ -s /tmp/r.json ]
        code=0; $command run many --bodies 5 --frames 2 --quiet --view /tmp/p.html 2>/dev/null || code=\$?; [ \$code = $page ]
        code=0; $command render many --bodies 3 --out /tmp/p.png >/dev/null 2>&1 || code=\$?; [ \$code = 0 ] || [ \$code = 71 ]" ||
        { echo "try: $command does not work in $root" >&2; exit 1; }
}

rm -rf "$bare/opt/"* "$bare/srv/"*
tar -xzf "$archive" -C "$bare/opt"
mount -t proc proc "$bare/proc" 2>/dev/null || true
trap 'umount "$bare/proc" 2>/dev/null; rm -rf "$work"' EXIT
cd "$bare"
folder=$(echo opt/oncollide-*)
works_in "$bare" "/$folder/bin/oncollide" 0
mv "$folder" "srv/moved about"
ln -sf "/srv/moved about/bin/oncollide" usr/local/bin/oncollide
works_in "$bare" oncollide 0
works_in "$bare" "env ONCOLLIDE_LIBC=bundled oncollide" 0
rm usr/local/bin/oncollide
echo "try: the archive works in a bare Debian, in any folder, with the system's C library and with the bundled one"

cd "$work"
mkdir -p nothing/{bin,tmp,proc,dev}
apt-get -qq -o APT::Sandbox::User=root download busybox-static >/dev/null && dpkg-deb -x busybox-static_*.deb busybox
cp busybox/bin/busybox nothing/bin/
for name in sh dirname readlink env grep; do ln -s busybox nothing/bin/$name; done
: >nothing/dev/null
cp -r "$bare/srv/moved about" nothing/oncollide
works_in "$work/nothing" /oncollide/bin/oncollide 0
echo "try: the archive works in a system without libraries"

cp "$deb" "$bare/tmp/oncollide.deb"
cp "$lab" "$bare/tmp/oncollide-lab.deb"
install_deb() {
    chroot "$bare" sh -c "apt-get -qq update && apt-get -qq install -y --no-install-recommends $1" >"$work/log" 2>&1 ||
        { tail "$work/log" >&2; exit 1; }
}
peers='embree|bullet|libode|libgmp|libmpfr|libcgal|libboost|googletest|libgtest'
install_deb /tmp/oncollide.deb
! dpkg-deb -f "$deb" Depends | grep -E "$peers" || { echo "try: the .deb of oncollide depends on peers" >&2; exit 1; }
works_in "$bare" oncollide 66
chroot "$bare" sh -c 'test -s /usr/share/man/man1/oncollide-run.1 && test -s /usr/share/bash-completion/completions/oncollide'
install_deb /tmp/oncollide-lab.deb
chroot "$bare" sh -euc 'oncollide-lab doctor | grep -q "^peers .*Embree.*ODE"
                        oncollide-lab hard --count 10 --family coplanar | grep -q "no collision missed"
                        test -s /usr/share/man/man1/oncollide-lab-bench.1'
echo "try: the .deb of oncollide-lab installs with the libraries that it compares with, and works"
chroot "$bare" apt-get -qq remove -y oncollide >/dev/null 2>&1
echo "try: the .deb installs, works and can be removed in a bare Debian"
