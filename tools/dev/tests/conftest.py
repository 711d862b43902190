# SPDX-License-Identifier: MIT
"""The tests of what proves pixstep: the common fixtures, and `pixstep-dev` as the command."""

import pytest

from pixstep_dev.cli.main import main

pytest_plugins = ["pytester", "common_fixtures"]


@pytest.fixture
def invoked():
    """Return the command that `invoke` runs."""
    return main
