"""Fails if a source calls a function of std::filesystem in its form that throws: no name of a file may end the program with an
internal fault. base/files/paths.hpp has the same questions with errors that name the path.

throwing_paths.py SOURCE_FOLDER
"""

import pathlib
import re
import sys

FOLDERS = "base scenes broadphase narrowphase pipeline robots runs samples tools python/source clients".split()
ASKED = ("absolute|canonical|weakly_canonical|relative|proximate|current_path|temp_directory_path|exists|equivalent|file_size|status|"
         "symlink_status|is_directory|is_regular_file|is_empty|is_symlink|is_fifo|is_socket|is_other|is_block_file|is_character_file|"
         "read_symlink|last_write_time|space|permissions|hard_link_count|create_directory|create_directories|create_symlink|copy|"
         "copy_file|remove|remove_all|rename|resize_file|directory_iterator|recursive_directory_iterator")
CALL = re.compile(r"\b(?:fs|filesystem)::(" + ASKED + r")(?:\s+\w+)?\(")


def arguments(text, at):
    """The text of a call's arguments; `at` is behind its opening parenthesis."""
    depth, begin = 1, at
    while depth and at < len(text):
        depth += {"(": 1, ")": -1}.get(text[at], 0)
        at += 1
    return text[begin:at - 1]


def main():
    root, calls, throwing = pathlib.Path(sys.argv[1]), 0, []
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*.[ch]pp")):
            text = re.sub(r"//[^\n]*", "", path.read_text())
            for match in CALL.finditer(text):
                given = arguments(text, match.end())
                calls += 1
                # The other form ends with an error_code; questions about a file_status throw nothing.
                if not re.search(r"(?:^|,\s*)(error|ignored|none|gone|status)$", given.strip()):
                    line = text.count("\n", 0, match.start()) + 1
                    throwing.append(f"{path.relative_to(root)}:{line}: {match[0]}{given})")
    print(f"{calls} calls of std::filesystem")
    if calls < 20 or throwing:
        sys.exit("these throw; use base/files/paths.hpp, or give an error_code (error, ignored, none or gone):\n" + "\n".join(throwing))


main()
