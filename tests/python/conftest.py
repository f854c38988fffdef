"""Shared by the tests of the Python package. ctest runs them on build/PRESET/python; by hand:
PYTHONPATH=build/release/python pytest tests/python"""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import oncollide

SOURCE = Path(__file__).resolve().parents[2]


def at(x, y=0.0, z=0.0):
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def random_poses(count, reach, seed):
    """Random poses, each coordinate within +-reach: (count, 7)."""
    rng = np.random.default_rng(seed)
    quaternions = rng.normal(size=(count, 4))
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    return np.hstack([rng.uniform(-reach, reach, (count, 3)), quaternions])


def matrices(poses):
    """(N, 7) as (N, 4, 4), by formulas independent of the package."""
    x, y, z, w = poses[:, 3:].T
    made = np.tile(np.eye(4), (len(poses), 1, 1))
    made[:, 0, :3] = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], axis=1)
    made[:, 1, :3] = np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], axis=1)
    made[:, 2, :3] = np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], axis=1)
    made[:, :3, 3] = poses[:, :3]
    return made


class Cube:
    """A mesh with the interface of another library."""

    def __init__(self, side=1.0):
        self.vertices = side * np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
        self.faces = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6],
                               [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])  # fmt: skip


@pytest.fixture
def run_python(tmp_path):
    """Runs a program in a separate interpreter; returns (exit code, output, errors)."""

    def run(code, timeout=60, **environment):
        done = subprocess.run(
            [sys.executable, "-c", code], cwd=tmp_path, timeout=timeout, text=True, capture_output=True,
            env={**os.environ, "PYTHONPATH": str(Path(oncollide.__file__).absolute().parents[1]), **environment})  # fmt: skip
        return done.returncode, done.stdout, done.stderr

    return run
