"""Fails where an installed header uses an extension of GNU or a header of one operating system, outside of `#ifdef __GNUC__`.
-pedantic-errors does not refuse attributes, builtins and __extension__, which MSVC does not know.

standard_headers.py INSTALLED_HEADER...
"""

import pathlib
import re
import sys

FOREIGN = re.compile(r"__(?:attribute|builtin|int128|extension|typeof|restrict|asm)\w*|\btypeof\b|\basm\b|\bssize_t\b|"
                     r"#\s*include\s*<(?:unistd|fcntl|dlfcn|poll|pthread|windows|io|sys/\w+|x86intrin|immintrin)\.h>")
CONDITION = re.compile(r"\s*#\s*(if|ifdef|ifndef|elif|else|endif)\b(.*)")


def faults_of(header):
    text = re.sub(r"//[^\n]*", "", pathlib.Path(header).read_text())
    open_conditions, faults = [], []
    for number, line in enumerate(text.split("\n"), 1):
        if condition := CONDITION.match(line):
            word, rest = condition.groups()
            if word.startswith("if"):
                open_conditions.append(word != "ifndef" and "__GNUC__" in rest)
            elif word == "endif":
                open_conditions.pop()
            else:
                open_conditions[-1] = False
        elif not any(open_conditions) and (found := FOREIGN.search(line)):
            faults.append(f"{header}:{number}: {found[0]}: MSVC does not know it")
    return faults


def main():
    faults = [fault for header in sys.argv[1:] for fault in faults_of(header)]
    if len(sys.argv) < 20:
        faults.append(f"only {len(sys.argv) - 1} headers are read")
    sys.exit("\n".join(faults) or 0)


main()
