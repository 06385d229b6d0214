"""A generated strip of cloth that rolls up until it runs into itself, and the program to compare with."""
import os
import pathlib
import subprocess

import numpy as np
import pytest

import foldproof


def strip(length=60, width=4):
    """Triangles of a strip, (length + 1) x (width + 1) vertices."""
    v = np.arange((length + 1) * (width + 1)).reshape(length + 1, width + 1)
    a, b, c, d = v[:-1, :-1], v[1:, :-1], v[1:, 1:], v[:-1, 1:]
    return np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))]).astype(np.uint32)


def rolled(turn, length=60, width=4):
    """Its vertices when its ends are turned against each other by an angle; slanted, so that little is degenerate."""
    angle = turn * np.arange(length + 1) / length
    x, z = np.cumsum(np.cos(angle)), np.cumsum(np.sin(angle))
    across = np.arange(width + 1.0)
    points = np.stack(np.broadcast_arrays(x[:, None] + 0.1 * across, across, z[:, None]), axis=-1)
    return np.ascontiguousarray(points.reshape(-1, 3))


def rolling(turns, **size):
    return np.stack([rolled(turn, **size) for turn in turns])


@pytest.fixture(scope="session")
def triangles():
    return strip()


@pytest.fixture(scope="session")
def frames():
    return rolling(np.linspace(0.5, 9, 12))


@pytest.fixture(scope="session")
def motion(triangles, frames):
    return foldproof.Motion(triangles, frames)


@pytest.fixture(scope="session")
def model(triangles):
    return foldproof.train(foldproof.Motion(triangles, rolling(np.linspace(0.2, 3, 8))))


@pytest.fixture
def program(tmp_path):
    """Runs build/foldproof in a directory of its own."""
    path = os.environ.get("FOLDPROOF_PROGRAM")
    if not path or not pathlib.Path(path).exists():
        pytest.skip("FOLDPROOF_PROGRAM does not name the program")

    def run(*arguments):
        return subprocess.run([path, *map(str, arguments)], cwd=tmp_path, capture_output=True, text=True, timeout=120)

    return run
