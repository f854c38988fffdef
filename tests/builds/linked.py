"""The libraries that the installed command loads: these alone, so that its package depends on no other library's peer, judge
or test framework. The laboratory loads the peers of its build.

linked.py COMMAND LAB
"""

import re
import subprocess
import sys

# The libraries that the command may name, and Debian's packages of them: the dependencies of the package oncollide.
ALLOWED = {
    "libc": "libc6", "libm": "libc6", "ld-linux-x86-64": "libc6", "libgcc_s": "libgcc-s1", "libstdc++": "libstdc++6",
    "libgomp": "libgomp1", "libmpi": "libopenmpi3", "libfmt": "libfmt9", "libz": "zlib1g", "libpng16": "libpng16-16",
    "libexpat": "libexpat1", "libzip": "libzip4", "libyaml-cpp": "libyaml-cpp0.7", "libqhull_r": "libqhull-r8.0",
    "libmeshoptimizer": "libmeshoptimizer2d", "libepoxy": "libepoxy0", "liboctomap": "liboctomap1.9",
    "liboctomath": "liboctomap1.9", "libfcl": "libfcl0.7",
    "libasan": "libasan8", "libubsan": "libubsan1", "libtsan": "libtsan2",
}  # fmt: skip
# Nothing that the command loads may load these, directly or not.
REFUSED = r"lib(embree|tbb|Bullet|LinearMath|ode\b|CGAL|gmp|mpfr|boost|gtest|gmock)"


def needed(program):
    """The libraries that the program itself names."""
    lines = subprocess.run(["readelf", "-d", program], check=True, capture_output=True, text=True).stdout
    return [name.split(".so")[0] for name in re.findall(r"\(NEEDED\).*\[(.*)\]", lines)]


def loaded(program):
    """All files that the loader would load."""
    lines = subprocess.run(["ldd", program], check=True, capture_output=True, text=True).stdout
    return [line.split()[0] for line in lines.splitlines()]


def main():
    command, lab = sys.argv[1:]
    faults = [f"{command} needs {name}, which is not in ALLOWED" for name in needed(command) if name not in ALLOWED]
    faults += [f"{command} loads {name}" for name in loaded(command) if re.match(REFUSED, name)]
    # The laboratory has all commands of the library and more: without the same libraries it would be another file.
    if missing := set(needed(command)) - set(needed(lab)):
        faults.append(f"{lab} does not need {sorted(missing)}: is it the laboratory?")
    packages = sorted({ALLOWED[name] for name in needed(command) if name in ALLOWED})
    if "libstdc++6" not in packages:
        faults.append(f"{command}: only {packages} were found: is it a program?")
    print("the package oncollide depends on", ", ".join(packages))
    sys.exit("\n".join(faults) or 0)


if __name__ == "__main__":
    main()
