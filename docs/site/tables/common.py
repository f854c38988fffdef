"""How tables are made from docs/data: listed() makes a row of the table from each row of the data, by a dictionary from each
title to the cell; pivot() gathers the rows of the data that make one row of the table.
"""
import csv
import pathlib

DOCS = pathlib.Path(__file__).resolve().parents[2]


def rows_of(*names):
    rows = []
    for name in names:
        with open(DOCS / "data" / f"{name}.csv", newline="", encoding="utf-8") as file:
            rows += list(csv.DictReader(file))
    return rows


def pivot(rows, row, column):
    """Rows of the data by two keys: {row: {column: data}}. A key is the name of a column of the data, or a function."""
    made = {}
    key = lambda r, by: by(r) if callable(by) else r[by]
    for r in rows:
        made.setdefault(key(r, row), {})[key(r, column)] = r
    return made


def distinct(rows, column):
    return list(dict.fromkeys(r[column] for r in rows))


# How numbers are written.

def number(value):
    return f"{int(float(value)):,}"


def three(value):
    """Three digits: 0.0511, 7.69, 1,090."""
    value = float(value)
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}"


def short(value):
    """Three digits or fewer behind the point than anyone reads: 9.7, 17.6, 35, 1,801."""
    value = float(value)
    return f"{value:.1f}" if value < 20 else f"{value:,.0f}"


def span(ratios):
    """The range of ratios in a sentence: 8.7 to 10.5."""
    return f"{min(ratios):.1f} to {max(ratios):.1f}"


def of(column, form=number, scale=1):
    """The cell of a column of the data; `form` is one of the functions above, str or a format."""
    def cell(r):
        value = r[column] if scale == 1 else float(r[column]) * scale
        return form(value) if callable(form) else format(float(value), form)
    return cell


# Tables are written as Markdown.

def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def listed(rows, columns):
    return table(columns, [[cell(r) for cell in columns.values()] for r in rows])
