#!/usr/bin/env python3
"""The table of settings in docs/choosing.md, between <!-- settings --> and <!-- end -->, as the command prints it.

    settings.py --command OUT/bin/oncollide            fails if the page differs
    settings.py --command OUT/bin/oncollide --write    writes the page
"""
import argparse
import pathlib
import re
import subprocess
import sys

PAGE = pathlib.Path(__file__).resolve().parent.parent / "choosing.md"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--command", required=True)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    table = subprocess.run([options.command, "reference", "settings"], check=True, capture_output=True, text=True).stdout
    text = PAGE.read_text(encoding="utf-8")
    block = re.compile(r"(<!-- settings -->\n).*?(<!-- end -->)", re.S)
    if len(block.findall(text)) != 1:
        sys.exit(f"{PAGE}: no table between <!-- settings --> and <!-- end -->")
    wanted = block.sub(lambda found: found[1] + table + found[2], text)
    if options.write:
        PAGE.write_text(wanted, encoding="utf-8")
    elif wanted != text:
        sys.exit(f"{PAGE}: differs from 'oncollide reference settings'; run docs/site/settings.py --write")


if __name__ == "__main__":
    main()
