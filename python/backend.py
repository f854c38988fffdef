"""Builds the wheel, for `pip install .`: a zip of CMake's install component `python` (PEP 517, PEP 427).

It needs only Debian's packages (./dev python installs them), and no network, with or without build isolation.
    pip install . --config-settings build-dir=build/release    uses an existing build
"""

import base64
import hashlib
import os
import re
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def _project():
    text = (ROOT / "CMakeLists.txt").read_text()
    version = re.search(r"project\(oncollide VERSION ([0-9.]+)", text).group(1)
    return version, f"oncollide-{version}"


def _run(*command):
    print("oncollide:", *command, flush=True)
    if subprocess.run(command).returncode:
        raise SystemExit(
            f"oncollide: failed: {' '.join(map(str, command))}\n"
            "oncollide: './dev python' in a clone installs what the build needs, on Debian 12"
        )


def _build(folder):
    if not (folder / "build.ninja").exists():
        _run(
            *("cmake", "-G", "Ninja", "-S", ROOT, "-B", folder, "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_UNITY_BUILD=ON"),
            *("-DONCOLLIDE_TOOLS=OFF", "-DONCOLLIDE_TESTS=OFF", "-DONCOLLIDE_PYTHON=ON"),
            f"-DPython3_EXECUTABLE={sys.executable}",
        )
    _run("cmake", "--build", folder, "--target", "oncollide_python")


def _metadata(version):
    readme = (ROOT / "README.md").read_text()
    return (
        f"Metadata-Version: 2.1\nName: oncollide\nVersion: {version}\n"
        "Summary: Finds which bodies of a large environment collide, at a certified accuracy\n"
        "License: BSD-3-Clause\nRequires-Python: >=3.9\nRequires-Dist: numpy\nRequires-Dist: matplotlib; extra == 'plots'\n"
        f"Provides-Extra: plots\nDescription-Content-Type: text/markdown\n\n{readme}"
    )


def get_requires_for_build_wheel(config_settings=None):
    return []


def _dist_info():
    """Files of the wheel that describe it, by path."""
    version, stem = _project()
    return {
        f"{stem}.dist-info/METADATA": _metadata(version).encode(),
        f"{stem}.dist-info/WHEEL": f"Wheel-Version: 1.0\nGenerator: oncollide\nRoot-Is-Purelib: false\nTag: {_tag()}\n".encode(),
        f"{stem}.dist-info/LICENSE": (ROOT / "LICENSE").read_bytes(),
    }


def _tag():
    python = f"cp{sys.version_info[0]}{sys.version_info[1]}"
    return f"{python}-{python}-" + sysconfig.get_platform().replace("-", "_").replace(".", "_")


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    for path, data in _dist_info().items():
        file = Path(metadata_directory, path)
        file.parent.mkdir(exist_ok=True)
        file.write_bytes(data)
    return f"{_project()[1]}.dist-info"


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    stem = _project()[1]
    folder = Path((config_settings or {}).get("build-dir", ROOT / "build" / f"wheel-{_tag().partition('-')[0]}"))
    _build(folder)
    name = f"{stem}-{_tag()}.whl"
    with tempfile.TemporaryDirectory() as staging:
        _run("cmake", "--install", folder, "--component", "python", "--prefix", staging, "--strip")
        files = {str(f.relative_to(staging)): f.read_bytes() for f in sorted(Path(staging).rglob("*")) if f.is_file()}
    files.update(_dist_info())
    record = ""
    for path, data in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        record += f"{path},sha256={digest},{len(data)}\n"
    files[f"{stem}.dist-info/RECORD"] = (record + f"{stem}.dist-info/RECORD,,\n").encode()
    with zipfile.ZipFile(os.path.join(wheel_directory, name), "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, data in files.items():
            wheel.writestr(zipfile.ZipInfo(path, (2020, 1, 1, 0, 0, 0)), data, zipfile.ZIP_DEFLATED)
    return name


def build_sdist(sdist_directory, config_settings=None):
    raise SystemExit("oncollide: there is no source distribution; build from a clone: pip install .")
