#!/usr/bin/env python3
"""Counts sentences that are not plain technical English, in comments, messages, help texts and pages.

    plain_english.py              every mark, as FILE:LINE: [rule] sentence
    plain_english.py PATH ...     the same for some files or folders
    plain_english.py --count      marks per folder and in all
    plain_english.py --check      fails where a file has more marks than plain_english_limits.csv allows
    plain_english.py --record     lowers the recorded limits to the present counts; never raises one

A rule is a pattern that was found to mark sentences that readers stumble over: no subject, a pronoun without a noun, an
inverted or elliptic clause, or a word of our own where the field has a term. Passing is a floor: a sentence without a mark
can still be hard to read.
"""
import argparse
import csv
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LIMITS = Path(__file__).with_name("plain_english_limits.csv")
# Files without prose, and the files that name the words that are marked.
SKIPPED = ("docs/data/", "docs/site/plain_english")

# (name, pattern). Patterns are searched in one sentence; (?i) where case does not matter.
RULES = [(name, re.compile(pattern)) for name, pattern in [
    ("no subject", r"^(Of|What|Whatever|Wherever|But|Nor|Than|Those|Such|Else|Alike|So)\b(?! (a|an|the|this|these|many|few)? ?\w+ (is|are|has|have|does|do)\b.*\?)"),
    ("no subject", r"^(Where|By|With|Without|For|As|From|Beside|Besides|Beyond|Among|Nothing else)\b[^,:]*[.;]?$"),
    ("question", r"^(Is|Are|Does|Do|Did|Has|Have|Can|May|Must|Was|Were|Should|Could|How|Which|Who|Why)\b.*\?$|^(Is|Are|Does|Did|Has|Was|Were) (it|there|the|a|an|any|this|all|each|both|one|some)\b"),
    ("pronoun without a noun", r"(?i)\bthose (that|which|who|whose|of|in|on|with|by|at|from|for|without|not|before|behind|near)\b|\bthat of\b|\b(one|ones) (each|of which)\b"),
    ("pronoun without a noun", r"(?i)(?<!know )(?<!knows )(?<!say )(?<!says )(?<!see )(?<!sees )(?<!show )(?<!shows )(?<!state )(?<!states )(?<!shown )(?<!exactly )(?<!decide )(?<!decides )(?<!explain )(?<!explains )\bwhat\b(?! (it|this|that) (is|does|means)\b)"),
    ("pronoun without a noun", r"\b(all|nothing|anything|everything) that\b|\bwhatever\b"),
    ("so without that", r"(?i)\bso (many|much|few|large|small|long|manieth|often|near|deep|little)\b(?!.{0,60}\bthat\b)(?! as)"),
    ("ask, tell, answer", r"(?i)\b(ask|asks|asked|asking|tell|tells|told|telling|answer|answers|answered|answering)\b"),
    ("but for except", r"(?i)\bbut for\b|\b(all|nothing|none|any|anything|everything|no one|nobody|each|every) but\b|\bbut (those|one|what|that of|of)\b"),
    ("inversion", r"^(So|Thus|Only|Nor|Neither|Never|Here|There|Then) (is|are|does|do|did|can|has|have|goes|go|come|comes|may)\b(?<!There is)(?<!There are)(?<!There can)(?<!There may)"),
    ("inversion", r"(?i)\bnor (is|are|does|do|did|can|has|have|may|may)\b|, and so (is|are|does|do|it is)\b|\bso (it )?(is|are|does|do) (it|those|they) of\b"),
    ("noun missing", r"(?i)\b(nothing|none|anything|something) such\b|\bsuch (is|are|that is)\b|\bthe (former|latter)s?\b"),
    ("idiom", r"(?i)\ball the same\b|\bin any company\b|\bfor want of\b|\bmakes? nothing of\b|\bnothing of (it|them)\b|\bturn about\b|\bby turns\b|\bnothing for it\b|\bbeside each other\b|\bgone elsewhere\b|\bto no avail\b|\bhad of old\b"),
    ("per", r"(?i)\b(ms|ns|us|µs|microseconds?|milliseconds?|seconds?|bytes?|bits?|kB|MB|MiB|GB|times|points|pairs|triangles|steps|pictures|lines?) an? (frame|body|pair|triangle|node|cell|box|row|second|query|mesh|model|pose|contact|process|rank|side|vertex|piece|chunk|tile|point|look|edge|file|name|field|stage|pixel)s?\b"),
    ("word of our own", r"(?i)\b(?:so |many|every )?manieth\b|\bturned (box|boxes|mesh|meshes|body|bodies|model|shape|shapes|frame)\b|\b(is|are|shown) shown along\b|\bfarthest along\b|\bpassing models?\b|\bcourses?\b(?! of)|\bin the course of\b|\btight spheres?\b|\bno numbers?\b|\blook-ahead\b|\bborrow(s|ed)?\b|\bworn\b|\bparts? (it|them) soon|\breach into\b|\btakes? (it|them) for\b"),
]]

Sentence = tuple[int, str]


def sentences_of(lines: list[tuple[int, str]]) -> list[Sentence]:
    """Splits one block of running text, given as (line number, text), at the ends of sentences."""
    found: list[Sentence] = []
    start, text = 0, ""
    for number, line in lines:
        line = line.strip()
        if not line or re.match(r"^([-*|>#]|\d+\.|@\w+|---)", line):
            if text:
                found.append((start, text))
            text = ""
            line = re.sub(r"^([-*>#]+|\d+\.|@(param|returns?|throws?)\s*\w*|-+)\s*", "", line)
        for piece in re.split(r"(?<=[.?!:;])\s+(?=[A-Z`(])", line):
            if not text:
                start = number
            text = f"{text} {piece}".strip()
            if re.search(r"[.?!:;]$", piece) and not re.search(r"\b(e\.g|i\.e|cf|vs|al|Fig|Sec)\.$", piece):
                found.append((start, text))
                text = ""
    if text:
        found.append((start, text))
    return [(number, re.sub(r"`[^`]*`", "`x`", sentence)) for number, sentence in found if sentence]


def c_prose(text: str) -> list[list[tuple[int, str]]]:
    """Comments, block by block, and string literals of at least four words, of C++ or JavaScript."""
    blocks: list[list[tuple[int, str]]] = []
    pattern = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\((.*?)\)\1"|"(?:[^"\\\n]|\\.)*"|\'(?:[^\'\\\n]|\\.)+\'', re.S)
    last_line, last_column = -1, -1
    literal_end = None
    for match in pattern.finditer(text):
        token = match.group()
        line = text.count("\n", 0, match.start()) + 1
        if token.startswith("//"):
            column = match.start() - text.rfind("\n", 0, match.start())
            words = re.sub(r"^//[/!]?<?", "", token)
            own_line = not text[text.rfind("\n", 0, match.start()) + 1:match.start()].strip()
            if blocks and line == last_line + 1 and own_line and column == last_column:
                blocks[-1].append((line, words))
            else:
                blocks.append([(line, words)])
            last_line, last_column = line, column
            literal_end = None
        elif token.startswith("/*"):
            blocks.append([(line + i, re.sub(r"^\s*\*+\s?|/\*+|\*/", "", words)) for i, words in enumerate(token.split("\n"))])
            literal_end = None
        elif token.startswith(("\"", "R\"")):
            words = match.group(2) if token.startswith("R") else re.sub(r"\\[nt]", " ", token[1:-1])
            adjacent = literal_end is not None and not text[literal_end:match.start()].strip()
            if adjacent and not token.startswith("R"):
                blocks[-1].append((line, words))
            else:
                blocks.append([(line + i, row) for i, row in enumerate(words.split("\n"))] if token.startswith("R")
                              else [(line, words)])
                blocks[-1].insert(0, (0, ""))  # marks a literal
            literal_end = match.end()
    kept = []
    for block in blocks:
        if block[0] == (0, ""):
            joined = " ".join(words for _, words in block)
            # Neither code nor an option with the words for its value.
            if len(re.findall(r"[A-Za-z]{2,}", joined)) < 4 or re.search(r"[;{}]\s*$|^\s*(#|<|\w+ *=)|^\s*\S+ \S*\w\|\w", joined):
                continue
            block = block[1:]
        kept.append(block)
    return kept


def hash_prose(text: str, python: bool) -> list[list[tuple[int, str]]]:
    """Comments that begin with #, and in Python docstrings and long literals."""
    blocks: list[list[tuple[int, str]]] = []
    last = -1
    for number, line in enumerate(text.split("\n"), 1):
        match = re.match(r"^(\s*|.*\s)#(?!!)\s?(.*)$", line)
        if match and line.count('"') % 2 == 0:
            if number == last + 1 and not match.group(1).strip():
                blocks[-1].append((number, match.group(2)))
            else:
                blocks.append([(number, match.group(2))])
            last = number
    if python:
        for match in re.finditer(r'"""(.*?)"""', text, re.S):
            line = text.count("\n", 0, match.start()) + 1
            blocks.append([(line + i, words) for i, words in enumerate(match.group(1).split("\n"))])
    return blocks


def markdown_prose(text: str) -> list[list[tuple[int, str]]]:
    """Running text, list items and cells of tables; no code."""
    blocks: list[list[tuple[int, str]]] = [[]]
    fenced = False
    for number, line in enumerate(text.split("\n"), 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
            blocks.append([])
        elif fenced or line.startswith("    "):
            continue
        elif line.lstrip().startswith("|"):
            blocks += [[(number, cell)] for cell in line.strip().strip("|").split("|") if len(cell.split()) > 3]
            blocks.append([])
        elif not line.strip():
            blocks.append([])
        else:
            blocks[-1].append((number, re.sub(r"\]\([^)]*\)", "]", line)))
    return [block for block in blocks if block]


def prose_of(path: Path) -> list[list[tuple[int, str]]]:
    text = path.read_text(encoding="utf-8", errors="replace")
    if path.suffix in (".cpp", ".hpp", ".js", ".css", ".in"):
        return c_prose(text)
    if path.suffix == ".md":
        return markdown_prose(text)
    if path.suffix in (".py", ".pyi"):
        return hash_prose(text, python=True)
    if path.suffix in (".cmake", ".txt", ".sh", ".toml", ".yml") or path.name in ("dev", "run"):
        return hash_prose(text, python=False)
    return []


def marks_of(path: Path) -> list[tuple[int, str, str]]:
    """(line, rules, sentence) of every sentence that breaks a rule."""
    found = []
    for block in prose_of(path):
        for line, sentence in sentences_of(block):
            rules = []
            for name, pattern in RULES:
                if name not in rules and pattern.search(sentence):
                    rules.append(name)
            if rules:
                found.append((line, ", ".join(rules), sentence))
    return found


def files(paths: list[str]) -> list[Path]:
    try:
        listed = subprocess.run(["git", "ls-files", "--", *paths], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\n")
    except (OSError, subprocess.CalledProcessError):  # an unpacked archive
        listed = [str(p.relative_to(ROOT)) for p in ROOT.rglob("*") if "build" not in p.parts]
    return [ROOT / name for name in sorted(set(listed)) if name and not name.startswith(SKIPPED) and (ROOT / name).is_file()
            and not (ROOT / name).is_symlink()]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("paths", nargs="*")
    parser.add_argument("--count", action="store_true")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--record", action="store_true")
    arguments = parser.parse_args()

    marks = {str(path.relative_to(ROOT)): marks_of(path) for path in files(arguments.paths)}
    counts = {name: len(found) for name, found in marks.items() if found}
    if arguments.count:
        folders: dict[str, int] = {}
        for name, count in counts.items():
            folder = name.split("/")[0] if "/" in name else "."
            folders[folder] = folders.get(folder, 0) + count
        for folder, count in sorted(folders.items()):
            print(f"{count:6} {folder}")
        print(f"{sum(counts.values()):6} in all")
        return 0

    limits = {}
    if LIMITS.exists():
        with LIMITS.open(newline="") as file:
            limits = {row["file"]: int(row["marks"]) for row in csv.DictReader(file)}
    if arguments.record:
        kept = {name: min(count, limits.get(name, count) if LIMITS.exists() else count) for name, count in counts.items()}
        with LIMITS.open("w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["file", "marks"])
            writer.writerows(sorted(kept.items()))
        return 0

    failed = False
    for name, found in marks.items():
        over = len(found) - limits.get(name, 0) if arguments.check else len(found)
        if over <= 0:
            continue
        failed = True
        for line, rules, sentence in found:
            print(f"{name}:{line}: [{rules}] {sentence}")
        if arguments.check:
            print(f"{name}: {len(found)} marks, {limits.get(name, 0)} allowed; write the sentences above with subject, verb and object")
    return 1 if failed and arguments.check else 0


if __name__ == "__main__":
    sys.exit(main())
