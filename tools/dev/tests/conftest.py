# SPDX-License-Identifier: MIT
"""The tests of what proves pixstep: the common fixtures, and `pixstep-dev` as the command."""

import pytest

from common_fixtures import invoker
from pixstep_dev.cli.main import main

pytest_plugins = ["pytester", "common_fixtures"]


@pytest.fixture
def invoke(tmp_path, monkeypatch):
    """Return a function that runs `pixstep-dev` in an empty folder: status, output, stderr."""
    monkeypatch.chdir(tmp_path)
    return invoker(main)
