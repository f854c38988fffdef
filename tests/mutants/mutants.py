#!/usr/bin/env python3
"""Plants the faults of mutants.json one by one in the sources, and writes the tests that find each to docs/data/mutants.csv.

    mutants.py [--build build/release] [NAME...]    NAME: a part of the fault's name; all faults if there is none
    mutants.py --check                              whether each fault's text is in its file, as a test does

Each fault is an entry with its file, the text that it replaces (once in the file), the targets to build, and a regular
expression of ctest: the tests in which it should be found. A fault that no test finds ends in exit code 1, and needs a new
test. The sources are restored at the end, also after Ctrl-C. ctest runs only --check: each fault takes a build.
"""
import argparse
import csv
import json
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
DATA = ROOT / "docs/data/mutants.csv"
COLUMNS = ["fault", "file", "from", "to", "tests", "failed", "found_by"]


def run(*command):
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True)


def build(folder, mutant):
    """Ends the program if the targets do not compile: a mutant must be a fault that a compiler does not find."""
    made = run("ninja", "-C", folder, *mutant["target"].split())
    if made.returncode:
        raise SystemExit(f"{mutant['fault']}: it does not compile:\n{made.stdout[-3000:]}")


def failing(folder, tests):
    """Runs the tests of matching names and returns the failing ones."""
    done = run("ctest", "--test-dir", folder, "-j2", "--timeout", "300", "-R", tests)
    if "No tests were found" in done.stdout + done.stderr:
        raise SystemExit(f"no test matches {tests}")
    return re.findall(r"^\s+\d+ - (\S+) \(", done.stdout, re.MULTILINE)


def source_of(mutant):
    """Path and text of the file. Ends the program if it does not hold the text to replace once."""
    path = ROOT / mutant["file"]
    text = path.read_text(encoding="utf-8")
    if text.count(mutant["from"]) != 1:
        raise SystemExit(f"{mutant['fault']}: {mutant['file']} has '{mutant['from']}' {text.count(mutant['from'])} times, not once")
    return path, text


def examine(folder, mutant):
    """Names of the tests that fail with the fault."""
    path, text = source_of(mutant)
    try:
        path.write_text(text.replace(mutant["from"], mutant["to"]), encoding="utf-8")
        build(folder, mutant)
        return failing(folder, mutant["tests"])
    finally:
        path.write_text(text, encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default="build/release", help="a configured build folder")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("names", nargs="*", metavar="NAME")
    options = parser.parse_args()
    mutants = json.loads((HERE / "mutants.json").read_text(encoding="utf-8"))
    if options.check:
        for mutant in mutants:
            source_of(mutant)
        return
    known = {}
    if DATA.exists():
        with open(DATA, newline="", encoding="utf-8") as file:
            known = {row["fault"]: row for row in csv.DictReader(file)}
    chosen = [m for m in mutants if not options.names or any(name in m["fault"] for name in options.names)]
    if not chosen:
        sys.exit("no such fault; there are: " + ", ".join(m["fault"] for m in mutants))
    for mutant in chosen:  # the tests must pass without faults
        build(options.build, mutant)
        if failed := failing(options.build, mutant["tests"]):
            sys.exit("these tests fail without any fault: " + " ".join(failed))
    for mutant in chosen:
        found_by = examine(options.build, mutant)
        row = {key: mutant[key] for key in COLUMNS[:5]}
        known[mutant["fault"]] = {**row, "failed": len(found_by), "found_by": " ".join(found_by[:4])}
        print(f"{mutant['fault']}: {len(found_by)} tests fail: {' '.join(found_by[:4])}", flush=True)
        with open(DATA, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(known[m["fault"]] for m in mutants if m["fault"] in known)
    sys.exit(any(known[m["fault"]]["failed"] == 0 for m in chosen))


if __name__ == "__main__":
    main()
