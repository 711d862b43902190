# SPDX-License-Identifier: MIT
"""Options and fixtures: how many random lines, and what must have been built.

A test that needs a native program or an image is skipped when that is not built, unless
PIXSTEP_REQUIRE_BUILT is set (as the project's own test command does): then it fails.
"""

import os
import shutil

import pytest

from pixstep import natives


def pytest_addoption(parser):
    """Add --lines."""
    parser.addoption(
        "--lines", type=int, default=20, help="random lines per property test (default 20)"
    )


@pytest.fixture
def lines_option(request):
    """Return the number of random lines of each kind."""
    return request.config.getoption("--lines")


def _need(present: bool, what: str, lack: str = "is not built") -> None:
    if not present:
        text = f"{what} {lack}"
        if os.environ.get("PIXSTEP_REQUIRE_BUILT"):
            pytest.fail(text)
        pytest.skip(text)


@pytest.fixture
def plan_program():
    """Require pixstep-plan."""
    _need(natives.have("pixstep-plan"), "pixstep-plan")


@pytest.fixture(scope="session")
def simulator():
    """Require pixstep-sim and both images."""
    _need(natives.have("pixstep-sim"), "pixstep-sim")
    for board in ("uno", "mega"):
        _need(natives.have_image(board), f"the {board} image")


@pytest.fixture
def mbpoll():
    """Require the Modbus client mbpoll."""
    _need(shutil.which("mbpoll") is not None, "mbpoll", "is not installed")
