"""Runs the programs of the pages and of README.md unchanged."""

import csv
import os
import re
import shutil
from pathlib import Path

import pytest

import oncollide
from conftest import SOURCE


def blocks(page, fence):
    return "".join(re.findall(rf"^```{fence}\n(.*?)^```", (SOURCE / page).read_text(), re.DOTALL | re.MULTILINE))


@pytest.mark.parametrize("page", ["python", "planner", "from/trimesh"])
def test_pages_print_what_they_show(page, run_python):
    program, shown = blocks(f"docs/{page}.md", "python"), blocks(f"docs/{page}.md", "text")
    assert program and shown
    code, out, err = run_python(program)
    assert code == 0, err
    assert out == shown


def test_the_readmes_example_runs(run_python):
    program = blocks("README.md", "python")
    assert program
    code, out, err = run_python(program)
    assert code == 0, err
    assert "ring and ball: WITHIN" in out


COMMAND = os.environ.get("ONCOLLIDE_COMMAND", "oncollide")
THREE = Path("/usr/share/javascript/three/three.min.js")
NOTEBOOKS = sorted((SOURCE / "python" / "notebooks").glob("*.py"))


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
@pytest.mark.parametrize("plots", [True, False], ids=["with matplotlib", "without"])
def test_notebooks_run(notebook, plots, run_python, tmp_path):
    if plots:
        pytest.importorskip("matplotlib", reason="matplotlib is not installed: plots are not drawn")
    block = "" if plots else "import sys; sys.modules['matplotlib'] = None\n"
    code, out, err = run_python(f"{block}import runpy; runpy.run_path({str(notebook)!r}, run_name='__main__')", MPLBACKEND="Agg",
                                MPLCONFIGDIR=str(tmp_path))  # fmt: skip
    assert code == 0, err
    pictures = list(tmp_path.glob("*.png"))
    assert bool(pictures) == plots
    assert all(picture.stat().st_size > 5000 for picture in pictures)
    if not plots:
        assert "matplotlib" in out, "it prints why there is no picture"


@pytest.mark.skipif(not shutil.which(COMMAND), reason="the command oncollide is not built")
@pytest.mark.skipif(not THREE.exists(), reason="libjs-three is not installed")
def test_the_plan_of_a_robot_is_a_page(run_python, tmp_path):
    notebook = SOURCE / "python" / "notebooks" / "robot_plan.py"
    folder = Path(shutil.which(COMMAND)).parent
    code, out, err = run_python(f"import runpy; runpy.run_path({str(notebook)!r})", PATH=f"{folder}{os.pathsep}{os.environ['PATH']}")
    assert code == 0, err
    assert "all of them are free: True" in out and "no frame of plan.html has a contact" in out
    page = (tmp_path / "plan.html").read_text()
    assert page.startswith("<!DOCTYPE html>") and len(page) > 100_000


def test_notebooks_are_of_cells():
    assert len(NOTEBOOKS) == 4
    for notebook in NOTEBOOKS:
        assert notebook.read_text().count("\n# %%") >= 4


def test_the_benchmark_runs(run_python, tmp_path):
    script = SOURCE / "python" / "bench" / "overhead.py"
    arguments = ["overhead.py", "--seconds", "0.02", "--rounds", "1", "--csv", str(tmp_path / "o.csv")]
    code, out, err = run_python(f"import runpy, sys; sys.argv = {arguments}; runpy.run_path({str(script)!r}, run_name='__main__')")
    assert code == 0, err
    with open(tmp_path / "o.csv") as measured, open(SOURCE / "docs" / "data" / "python.csv") as shown:
        calls = [row["call"] for row in csv.DictReader(measured)]
        rows = list(csv.DictReader(shown))
    assert calls == [row["call"] for row in rows], "the page's data has other calls"
    page = (SOURCE / "docs" / "python.md").read_text()
    for row in rows:
        assert f"| `{row['call']}` | {int(row['items']):,} | {row['python_ns']} | {row['cpp_ns']} | {row['overhead_ns']} |" in page
