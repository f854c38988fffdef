"""Fails where a function of an installed header, samples aside, takes two neighbouring doubles: a call that swaps them would compile. Ends of
an interval of time are named in INTERVALS.

signatures.py INSTALLED_HEADER...
"""

import pathlib
import re
import sys

INTERVALS = {("from", "to"), ("begin", "end")}
NEIGHBOURS = re.compile(r"\bdouble (\w+)(?: = [^,()]*)?,\s*(?:const )?double (\w+)(?: = [^,()]*)?[,)]")


def main():
    faults = []
    for header in sys.argv[1:]:
        text = re.sub(r"//[^\n]*", "", pathlib.Path(header).read_text())
        faults += [f"{header}: double {first}, double {second}: make them members of a struct"
                   for first, second in NEIGHBOURS.findall(text) if (first, second) not in INTERVALS]
    if len(sys.argv) < 20:
        faults.append(f"only {len(sys.argv) - 1} headers are read")
    sys.exit("\n".join(faults) or 0)


if __name__ == "__main__":
    main()
