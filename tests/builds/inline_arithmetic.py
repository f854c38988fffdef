"""Compiles a program of all installed headers with -ffast-math, and fails if an inline function of oncollide computes with
floating-point numbers in it: the linker could give such a copy of the function to the library, and change its results.

inline_arithmetic.py COMPILER FOLDER OPTION...   FOLDER: include/oncollide of an installed copy
"""

import pathlib
import re
import subprocess
import sys
import tempfile

# Functions whose arithmetic is inside Eigen's, where ARITHMETIC does not see it: not inline at all.
OUT_OF_LINE = re.compile(r"oncollide::(Terrain::(x|y|point|height)|OccupancyMap::(box|cells_touching))\(")
ARITHMETIC = re.compile(r"\tv?(add|sub|mul|div|sqrt|fn?m(add|sub)\d*)[sp][sd]\s")


def main():
    compiler, folder, *options = sys.argv[1:]
    folder = pathlib.Path(folder)
    headers = sorted(p.relative_to(folder.parent) for p in folder.rglob("*.hpp"))
    with tempfile.TemporaryDirectory() as work:
        source, made = pathlib.Path(work, "all.cpp"), pathlib.Path(work, "all.o")
        source.write_text("".join(f"#include <{header}>\n" for header in headers))
        command = [compiler, "-std=c++20", "-O0", "-march=x86-64-v3", "-ffast-math", "-fkeep-inline-functions", f"-I{folder.parent}"]
        subprocess.run([*command, *options, "-c", source, "-o", made], check=True)
        weak = subprocess.run(["nm", "--defined-only", made], check=True, capture_output=True, text=True).stdout
        code = subprocess.run(["objdump", "-d", "--no-show-raw-insn", made], check=True, capture_output=True, text=True).stdout
        names = {line.split()[2] for line in weak.splitlines() if line.split()[1] in "Ww"}
        computing = []
        for part in code.split("\n\n"):
            match = re.match(r"\w+ <(\S+)>:\n", part)
            if match and match[1] in names and ARITHMETIC.search(part):
                computing.append(match[1])

    def plain(mangled):
        return subprocess.run(["c++filt"], input="\n".join(mangled), capture_output=True, text=True, check=True).stdout.splitlines()

    inline = [name for name in plain(computing) if re.match(r"(\w[\w:<>, ]* )?oncollide::", name)]
    inline += [name for name in plain(names) if OUT_OF_LINE.search(name)]
    print(f"{len(headers)} headers, {len(names)} inline functions")
    if not names or inline:
        sys.exit("inline arithmetic in installed headers:\n" + "\n".join(inline))


main()
