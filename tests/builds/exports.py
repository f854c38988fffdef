"""Compares the symbols that a shared library exports with the classes and functions that the installed headers mark with
ONCOLLIDE_API: the library must export these, and no others.

exports.py LIBRARY FOLDER MOST    FOLDER: the prefix's include/; MOST: symbols at most
"""

import pathlib
import re
import subprocess
import sys

# A name of namespace oncollide, its type information or its virtual table; the names follow, each after its length.
OURS = re.compile(r"_Z(?:T[ISV])?(?:N[KVRO]*)?9oncollide(\d.*)")
# Type information of std's exceptions is in every library that throws them.
STANDARD = re.compile(r"_ZT[ISV](N[KVRO]*)?St")
MARKED = re.compile(r"^(?:class|struct) ONCOLLIDE_API (\w+)|^ONCOLLIDE_API [^;()]*?[\s&*](\w+)\(", re.MULTILINE)
HIDDEN = re.compile(r"ONCOLLIDE_LOCAL\s+(\w+)")
# A function of a namespace that is not marked. Inline functions and templates need no mark.
UNMARKED = re.compile(r"^(?!ONCOLLIDE_API|inline|constexpr|template|using|static|struct|class|enum|friend|namespace|\[\[|return)"
                      r"[A-Za-z][\w:<>,&* ]* [&*]?(\w+)\(", re.MULTILINE)  # fmt: skip


def names(mangled):
    """The names of a symbol of ours from the outside in, without namespace oncollide; None for any other symbol."""
    match = OURS.fullmatch(mangled)
    if not match:
        return None
    found, rest = [], match[1]
    while length := re.match(r"\d+", rest):
        begin = length.end()
        end = begin + int(length[0])
        found.append(rest[begin:end])
        rest = re.sub(r"^B\d+cxx11", "", rest[end:])
    return found


def main():
    library, folder, most = sys.argv[1], pathlib.Path(sys.argv[2]), int(sys.argv[3])
    text = "".join(header.read_text() for header in sorted(folder.rglob("*.hpp")))
    marked, hidden = {a or b for a, b in MARKED.findall(text)}, set(HIDDEN.findall(text))
    nm = subprocess.run(["nm", "-D", "--defined-only", library], check=True, capture_output=True, text=True)
    exported = [line.split()[2] for line in nm.stdout.splitlines()]
    faults = [f"{name} is declared without ONCOLLIDE_API" for name in UNMARKED.findall(text)]
    seen = set()
    for symbol in exported:
        path = names(symbol)
        if path:
            seen.add(path[0])
        if (path and (path[0] not in marked or hidden & set(path))) or (not path and not STANDARD.match(symbol)):
            faults.append(f"exported, but not public: {symbol}")
    faults += [f"not exported: {name}" for name in sorted(marked - seen)]
    print(f"{len(exported)} symbols of {len(marked)} classes and functions")
    if len(exported) > most:
        faults.append(f"more than {most} symbols")
    sys.exit("\n".join(faults) or 0)


main()
