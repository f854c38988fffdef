"""Reads the anonymous namespaces of the libraries' sources, and fails where two files define the same name in one: CMake
may compile any files of a library as one unit, and which ones depends on the preset and on the packages that were found.
Functions may share a name if their parameters differ.

local_names.py PROJECT
"""

import collections
import pathlib
import re
import sys

LIBRARIES = ["base", "scenes", "scenes/files", "samples", "broadphase", "narrowphase", "pipeline", "robots", "runs", "tools/command"]
ALONE = re.compile(r"_kernel$|_absent$|^main$")  # compiled alone, or instead of another file
NAMESPACE = re.compile(r"^namespace ([\w:]+) \{$|^namespace \{\n(.*?)^\} // namespace$", re.MULTILINE | re.DOTALL)
RAW_STRING = re.compile(r'R"\w*\(.*?\)\w*"', re.DOTALL)
ALIAS = re.compile(r"^(using (\w+) = .*;)", re.MULTILINE)
TYPE = re.compile(r"^(?:struct|class|enum(?: class)?) (\w+)\b(?! *;)(?!::)", re.MULTILINE)
CONSTANT = re.compile(r"^(?:static |inline )*(?:constexpr|const|thread_local|std::atomic)\b[^(){};=]*?[ >&*](\w+)(?:\[\w*\])* ?[={]",
                      re.MULTILINE)
FUNCTION = re.compile(r"^(?!using|struct|class|enum|template|return|#)[\w:<>,&*\[\] ]*?[ &*>](\w+)\(([^{};]*?)\)(?: const| noexcept)*\n\{",
                      re.MULTILINE)


def definitions(text):
    """Yields each name that a source defines for itself, with its namespace, and its parameters, its alias or None."""
    where = ""
    for namespace, part in NAMESPACE.findall(text):
        where = namespace or where
        part = re.sub(r"//.*", "", RAW_STRING.sub("", part))
        yield from ((f"{where}::{name}", alias) for alias, name in ALIAS.findall(part))
        yield from ((f"{where}::{name}", None) for pattern in (TYPE, CONSTANT) for name in pattern.findall(part))
        yield from ((f"{where}::{name}", " ".join(parameters.split())) for name, parameters in FUNCTION.findall(part))


def main():
    project, faults, count = pathlib.Path(sys.argv[1]), [], 0
    for library in LIBRARIES:
        found = collections.defaultdict(lambda: collections.defaultdict(set))
        for source in sorted((project / library).rglob("*.cpp")):
            of_files = source.is_relative_to(project / "scenes/files")
            if "windows" in source.parts or ALONE.search(source.stem) or of_files != (library == "scenes/files"):
                continue
            for name, what in definitions(source.read_text()):
                found[name][what].add(source.relative_to(project).as_posix())
                count += 1
        for name, kinds in found.items():
            is_alias = all(what and what.startswith("using ") for what in kinds)
            clashing = [set().union(*kinds.values())] if None in kinds or (is_alias and len(kinds) > 1) else [] if is_alias else kinds.values()
            faults += [f"{name}: " + ", ".join(sorted(sources)) for sources in clashing if len(sources) > 1]
    if count < 1000:
        faults.append(f"only {count} names were found: are the sources read?")
    sys.exit("\n".join(faults) or 0)


if __name__ == "__main__":
    main()
