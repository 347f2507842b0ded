"""What the tests share: scenes small enough for many of them, and the command line beside Python."""

import os
import subprocess

import numpy as np
import pytest

import sheer

SIZE = (48, 27)


@pytest.fixture(scope="session")
def pane():
    """Half-transparent glass in a town square."""
    return sheer.open("pane")


@pytest.fixture(scope="session")
def layers():
    """Three panes of opacity 0.4, one behind the other, before a background."""
    return sheer.open("layers:count=3,alpha=0.4")


@pytest.fixture(scope="session")
def sheets():
    """Three sheets of opacity 0.4 before nothing, the nearest the largest to a camera in front of them."""
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    positions = np.concatenate([np.insert(corners, 2, depth, axis=1) for depth in (0.0, -0.5, -1.0)])
    indices = np.concatenate([4 * sheet + np.array([[0, 1, 2], [0, 2, 3]]) for sheet in range(3)])
    return sheer.Scene.from_arrays(positions, indices, [1.0, 0.5, 0.25, 0.4], name="sheets")


@pytest.fixture
def command_line(tmp_path):
    """Runs `sheer` in a folder of the test's own; `cargo xtask test` says where it is."""

    def run(text):
        done = subprocess.run(
            [os.environ["SHEER"], *text.split()], cwd=tmp_path, capture_output=True, text=True, timeout=300
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run
