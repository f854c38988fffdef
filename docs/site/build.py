#!/usr/bin/env python3
"""Makes the site of docs/: pages, the reference of the command line from its options, plots from docs/data, and the API.

    build.py --command OUT/bin/oncollide --lab OUT/bin/oncollide-lab --out FOLDER    the site is FOLDER/site/index.html

Needs MkDocs and its theme material. Without matplotlib the plots are left out, without Doxygen the API; with --complete that is an error,
and a league is run for its page.
"""
import argparse
import pathlib
import re
import shutil
import subprocess
import sys

SITE = pathlib.Path(__file__).resolve().parent
DOCS, SOURCE = SITE.parent, SITE.parent.parent
PLOTS = {
    "study": ("Speed against error", "speed-against-error"),
    "broad": ("Broad phase", "broad-phase"),
    "environments": ("Large environments", "large-environments"),
    "distances": ("Distances to large environments", "distances-to-large-environments"),
    "shape_distances": ("Distances of two shapes", "distances-to-large-environments"),
    "shapes": ("Close pairs of shapes", "close-pairs-of-shapes"),
    "gpu": ("Grey cells on a GPU", "grey-cells-on-a-gpu"),
    "reading": ("Reading files", "reading-files"),
    "contacts": ("Contacts of shapes", "contacts.md#piles-of-shapes-and-single-pairs"),
    "avalanche": ("An avalanche", "contacts.md#an-avalanche"),
}
DATA = {"study": "study/many.csv", "gpu": "gpu/h200.json", "contacts": "contacts/shapes.csv",
        "avalanche": "contacts/avalanche.csv"}  # of plots that several files are behind: the first
DOXYFILE = """
PROJECT_NAME = oncollide
INPUT = {inputs}
OUTPUT_DIRECTORY = {out}
HTML_OUTPUT = api
GENERATE_LATEX = NO
QUIET = YES
WARN_IF_UNDOCUMENTED = NO
EXTRACT_ALL = YES
INCLUDE_PATH = {include}
STRIP_FROM_PATH = {source}
HIDE_UNDOC_RELATIONS = YES
HAVE_DOT = NO
JAVADOC_AUTOBRIEF = YES
MACRO_EXPANSION = YES
EXPAND_ONLY_PREDEF = YES
PREDEFINED = ONCOLLIDE_API= ONCOLLIDE_LOCAL=
"""


def for_mkdocs(text):
    """GitHub wants bars in a table's code escaped, and MkDocs shows the backslash."""
    return re.sub(r"`[^`\n]*`", lambda code: code[0].replace("\\|", "|"), text)


def gather(pages):
    """Copies the pages. Links to sources and to the README become plain text, because the site does not have these files."""
    for folder in ("data", "pictures"):
        shutil.copytree(DOCS / folder, pages / folder)
    for page in DOCS.glob("**/*.md"):
        to = pages / page.relative_to(DOCS)
        to.parent.mkdir(exist_ok=True)
        text = page.read_text(encoding="utf-8")
        outside = r"\.\./" * len(page.relative_to(SOURCE).parent.parts)
        text = re.sub(rf"\[([^\]]*)\]\({outside}([^)]*)\)", r"\1 (`\2`)", text)
        text = text.replace("```cpp fcl\n", "```cpp\n")  # a mark for the tests
        # Cells of HTML tables hold Markdown.
        text = text.replace("<td>\n", '<td markdown="block">\n').replace("<table>", '<table markdown="block">')
        to.write_text(for_mkdocs(text), encoding="utf-8")


def write_reference(page, program):
    made = subprocess.run([program, "reference", "markdown"], check=True, capture_output=True, text=True).stdout
    page.write_text(for_mkdocs(made), encoding="utf-8")


def write_plots(pages, complete):
    text = "# Benchmarks, plotted\n\nDrawn from `docs/data`, as the commands in [Benchmarks](benchmarks.md) wrote them.\n"
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        if complete:
            sys.exit("build.py: no plots without matplotlib (python3-matplotlib)")
        text += "\nThis copy of the site has no plots: matplotlib was not there when it was built.\n"
    else:
        subprocess.run([sys.executable, SITE / "plots.py", pages / "plots"], check=True)
        for name, (title, place) in PLOTS.items():
            data = DATA.get(name, name + ".csv")
            text += f"\n## {title}\n\n![{title}](plots/{name}.svg)\n\n"
            text += f"[Figures](data/{data}), [how they were measured]({place if '#' in place else 'benchmarks.md#' + place})\n"
    (pages / "plots.md").write_text(text, encoding="utf-8")


def write_api(pages, out, complete):
    """Doxygen's pages, of the headers that are installed."""
    text = "# C++ API\n\n"
    if shutil.which("doxygen"):
        headers = []
        for listing in SOURCE.glob("*/CMakeLists.txt"):
            found = re.findall(r"HEADERS\s+(.*?)\n\s*[A-Z]+\b", listing.read_text(encoding="utf-8"), re.S)
            headers += [listing.parent / name for block in found for name in block.split() if name.endswith(".hpp")]
        config = out / "Doxyfile"
        config.write_text(DOXYFILE.format(inputs=" ".join(map(str, sorted(headers))), out=pages, include=SOURCE / "cmake/include",
                                          source=SOURCE), encoding="utf-8")  # fmt: skip
        subprocess.run(["doxygen", str(config)], check=True, stdout=subprocess.DEVNULL, stderr=(out / "doxygen.log").open("w"))
        # A page of HTML is no page for MkDocs, so the link is one for browsers only.
        text += 'Of the public headers: <a href="api/annotated.html">all classes</a>, <a href="api/files.html">all headers</a>.\n'
    elif complete:
        sys.exit("build.py: no API without Doxygen (doxygen)")
    else:
        text += "This copy of the site has no API pages: Doxygen was not there when it was built.\n"
    text += "\nThe headers are half documentation; `World` (`pipeline/world.hpp`) is where to begin.\n"
    (pages / "api.md").write_text(text, encoding="utf-8")


def write_league(pages, lab):
    """The page of the league, of a run of some minutes, and a link to it."""
    subprocess.run([lab, "league", "--cases", "500", "--quiet", "--out", pages / "league-run"], check=True, stdout=subprocess.DEVNULL)
    (pages / "league-run" / "league.steps").unlink()
    with open(pages / "league.md", "a", encoding="utf-8") as page:
        page.write("\n## The page\n\n[The page of a run of 500 cases of each family](league-run/league.html), made with this site.\n")


def add_try_page(pages):
    """The page to try the library in a browser, if './dev build --preset wasm' has made it, and a link to it."""
    page = SOURCE / "build" / "wasm" / "try.html"
    if page.exists():
        shutil.copy(page, pages / "try.html")
        with open(pages / "web.md", "a", encoding="utf-8") as web:
            web.write('\n## Try it\n\n<a href="try.html">The page</a>, made with this site.\n')


def check_links(site):
    """Every link and picture inside the site must lead somewhere, to its place in the page too, which MkDocs does not check."""
    found = [page for folder in ("", "notes/", "from/") for page in site.glob(f"{folder}*.html")]
    pages = {page: page.read_text(encoding="utf-8") for page in found}
    names = {page: set(re.findall(r'\bid="([^"]+)"', text)) for page, text in pages.items()}
    wrong = []
    for page, text in pages.items():
        for link in re.findall(r'\b(?:href|src)="([^"]+)"', text):
            path, _, place = link.partition("#")
            if re.match(r"[a-z]+:|//|/", link) or page.name == "404.html":
                continue
            target = (page.parent / path).resolve() if path else page
            target = target / "index.html" if target.is_dir() else target
            if not target.exists() or (place and target in names and place not in names[target]):
                wrong.append(f"{page.relative_to(site)}: {link}")
    if wrong:
        sys.exit("build.py: links that lead nowhere:\n  " + "\n  ".join(sorted(set(wrong))))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--command", required=True)
    parser.add_argument("--lab", required=True)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--complete", action="store_true", help="plots, API and a run of the league must be there")
    options = parser.parse_args()
    shutil.rmtree(options.out, ignore_errors=True)
    pages = options.out / "pages"
    pages.mkdir(parents=True)
    gather(pages)
    write_reference(pages / "reference.md", options.command)
    write_reference(pages / "reference-lab.md", options.lab)
    write_plots(pages, options.complete)
    write_api(pages, options.out, options.complete)
    add_try_page(pages)
    if options.complete:
        write_league(pages, options.lab)
    shutil.copy(SITE / "mkdocs.yml", options.out)
    subprocess.run([sys.executable, "-m", "mkdocs", "build", "--strict", "-f", options.out / "mkdocs.yml"], check=True)
    check_links(options.out / "site")


if __name__ == "__main__":
    main()
