#!/bin/bash
# Makes the folder PACKAGES/bench-gpu, and an archive of it, from the archive of ./dev package: bench_gpu.sh PACKAGES.
# It holds the files that 'oncollide-lab bench gpu' needs. Embree, half of the download, is left out: only 'bench broad', 'narrow' and
# 'rays' call it.
set -euo pipefail
cd "$1"
rm -rf bench-gpu
mkdir bench-gpu
tar -xzf oncollide-lab-*.tar.gz -C bench-gpu --strip-components=1
cd bench-gpu
rm -rf share lib/oncollide-lab/libembree*
for library in $(patchelf --print-needed lib/oncollide-lab/oncollide-lab | grep embree || true); do
    patchelf --remove-needed "$library" lib/oncollide-lab/oncollide-lab
done
cd ..
tar -czf bench-gpu.tar.gz bench-gpu
size=$(du -sm bench-gpu | cut -f1)
(( size <= 60 )) || { echo "bench_gpu.sh: the folder has $size MB, more than 60" >&2; exit 1; }
echo "$PWD/bench-gpu.tar.gz: unpack it anywhere and run 'bench-gpu/bin/oncollide-lab bench gpu' ($size MB unpacked)"
