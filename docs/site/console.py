#!/usr/bin/env python3
"""Runs the console sessions of a page: lines after "$ " (and "> " that go on) in one shell, whose output must be what the page shows.

    console.py --command OUT/bin/oncollide PAGE...
"""
import argparse
import os
import pathlib
import re
import subprocess
import sys
import tempfile


def steps_of(page):
    """Pairs of what is typed and what is printed."""
    steps = []
    for block in re.findall(r"^```console\n(.*?)^```", page.read_text(encoding="utf-8"), re.S | re.M):
        for line in block.splitlines():
            if line.startswith("$ "):
                steps.append([line[2:], ""])
            elif line.startswith("> "):
                steps[-1][0] += "\n" + line[2:]
            else:
                steps[-1][1] += line + "\n"
    if not steps:
        sys.exit(f"{page}: no block opens with ```console")
    return steps


def check(page, command):
    steps = steps_of(page)
    mark = "--- end of a step ---"
    # The mark must not change what $? says to the next step.
    script = "".join(f"{typed}\n{{ code=$?; echo '{mark}'; (exit $code); }}\n" for typed, _ in steps)
    path = f"{pathlib.Path(command).resolve().parent}:{os.environ['PATH']}"
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(["bash"], input=script, cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              env={**os.environ, "PATH": path, "ONCOLLIDE_DATA": ""})  # fmt: skip
    for (typed, shown), printed in zip(steps, done.stdout.split(mark + "\n")):
        if printed != shown:
            sys.exit(f"{page}: after '{typed}' the page shows\n{shown}but the command prints\n{printed}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--command", required=True)
    parser.add_argument("pages", nargs="+", type=pathlib.Path)
    options = parser.parse_args()
    for page in options.pages:
        check(page, options.command)


if __name__ == "__main__":
    main()
