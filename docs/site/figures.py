#!/usr/bin/env python3
"""Tables and figures of the pages and README.md, from docs/data, which the benchmarks wrote (tables/).

    figures.py --write     writes tables between <!-- figures: NAME --> and <!-- end -->, and figures within a sentence
                           between <!-- figure: NAME --> and <!-- end -->
    figures.py --check     fails if a page differs from its data

<!-- figures: NAME, TITLE = A | B --> keeps the rows of a table whose cell in the column TITLE is A or B.
"""
import argparse
import re
import sys

sys.dont_write_bytecode = True  # the sources stay clean

from tables import FIGURES, TABLES  # noqa: E402
from tables.common import DOCS  # noqa: E402

README = DOCS.parent / "README.md"
# On these pages every speed comes from the data.
HEADLINES = [README, DOCS / "index.md", DOCS / "choosing.md"]
TYPED = re.compile(r"\b[\d.,]+ times\b|"
                   r"\b(?:half|third|quarter|fifth|sixth|seventh|eighth|tenth) (?:as|of (?:the|its|FCL's) time)\b")
FIGURE = re.compile(r"(<!-- figure: (\w+) -->)(.*?)(<!-- end -->)", re.S)
TABLE = re.compile(r"(<!-- figures: (\w+)(?:, (.+?) = (.+?))? -->\n)(.*?)(<!-- end -->)", re.S)


def cells_of(row):
    return [cell.strip().replace("`", "") for cell in row.strip("|").split("|")]


def kept_rows(made, title, cells):
    """The rows of a table that have one of `cells` below `title`; code marks do not count."""
    header, line, *rows = made.splitlines()
    if title not in cells_of(header):
        sys.exit(f"no column is '{title}'; there are: {header}")
    column = cells_of(header).index(title)
    missing = set(cells) - {cells_of(row)[column] for row in rows}
    if missing:
        sys.exit(f"no row of '{title}' is {', '.join(missing)}")
    return "\n".join([header, line, *(row for row in rows if cells_of(row)[column] in cells)]) + "\n"


def update(write):
    wrong, typed, seen = [], [], set()
    for page in [README, *sorted(DOCS.glob("**/*.md"))]:
        text = page.read_text(encoding="utf-8")

        def make(kinds, name):
            if name not in kinds:
                sys.exit(f"{page.name}: no figures '{name}'; there are: {', '.join(kinds)}")
            seen.add(name)
            return kinds[name]()

        def replaced(name, begin, old, made, end):
            if old != made:
                wrong.append(f"{page.name}: {name}")
            return begin + made + end

        def with_table(match):
            begin, name, title, cells, old, end = match.groups()
            made = make(TABLES, name)
            if title:
                made = kept_rows(made, title, cells.split(" | "))
            return replaced(name, begin, old, f"\n{made}\n", end)

        def with_figure(match):
            begin, name, old, end = match.groups()
            made = make(FIGURES, name)
            return match[0] if " ".join(old.split()) == made else replaced(name, begin, old, made, end)

        marks = len(re.findall(r"<!-- figures?: ", text))
        if marks != len(TABLE.findall(text)) + len(FIGURE.findall(text)):
            sys.exit(f"{page.name}: a mark '<!-- figure' has another form; see figures.py --help")
        new = FIGURE.sub(with_figure, TABLE.sub(with_table, text))
        if page in HEADLINES:
            typed += [f"{page.name}: {match[0]}" for match in TYPED.finditer(FIGURE.sub("", text))]
        if write and new != text:
            page.write_text(new, encoding="utf-8")
    for name in (TABLES.keys() | FIGURES.keys()) - seen:
        sys.exit(f"no page shows the figures '{name}'")
    if typed:
        sys.exit("typed speeds; use <!-- figure: NAME -->: " + "; ".join(typed))
    if wrong and not write:
        sys.exit("not what docs/data says (docs/site/figures.py --write): " + "; ".join(wrong))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    group = parser.add_mutually_exclusive_group(required=True)
    group.add_argument("--write", action="store_true")
    group.add_argument("--check", action="store_true")
    update(parser.parse_args().write)


if __name__ == "__main__":
    main()
