"""pip install: a wheel of the existing build, installed to a separate folder."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import oncollide
from conftest import SOURCE

BUILD = Path(oncollide.__file__).absolute().parents[2]


@pytest.mark.skipif(not (BUILD / "build.ninja").exists(), reason="oncollide is not imported from a build folder")
@pytest.mark.parametrize("isolation", ["--no-build-isolation", "--no-index"])
def test_pip_installs_without_a_network(tmp_path, isolation):
    pytest.importorskip("pip", reason="pip is not installed (python3-pip)")
    install = [sys.executable, "-m", "pip", "install", isolation, "--no-deps", "--target", tmp_path / "there", SOURCE]
    done = subprocess.run([*install, "--config-settings", f"build-dir={BUILD}"], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    program = (
        "import oncollide, oncollide.trimesh, importlib.metadata as m; "
        "print(oncollide.__file__, m.version('oncollide'), len(m.files('oncollide')), oncollide.sphere(1.0))"
    )
    env = {**os.environ, "PYTHONPATH": str(tmp_path / "there")}
    ran = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, env=env, capture_output=True, text=True)
    assert ran.stdout.split()[:2] == [str(tmp_path / "there/oncollide/__init__.py"), oncollide.__version__], ran.stderr
    names = {path.name for path in (tmp_path / "there/oncollide").iterdir()}
    assert {"py.typed", "__init__.pyi", "trimesh.py", "trimesh.pyi"} <= names
    status = subprocess.run(["git", "status", "--porcelain"], cwd=SOURCE, capture_output=True, text=True)
    assert "wheel" not in status.stdout and "egg" not in status.stdout, "the clone stays clean"
