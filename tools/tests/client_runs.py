# SPDX-License-Identifier: MIT
"""Tests that need other programs' packages run by build/clients' interpreter.

Such a file lies in with_clients, where pytest does not look for tests by itself. What the
environment of the clients has not comes from that of this project, behind its own packages.
"""

import os
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CLIENTS = ROOT / "build" / "clients" / "bin" / "python"
_RUN = """
import sys
sys.path[:0], sys.path[len(sys.path):] = [sys.argv[1]], [sys.argv[2]]
import pytest
sys.exit(pytest.main(sys.argv[3:]))
"""


def run_tests(*names):
    """Run files of with_clients; fail with what they say if a test in them fails."""
    if not CLIENTS.exists():
        missing = f"{CLIENTS} is not there: run tools/setup"
        pytest.fail(missing) if os.environ.get("PIXSTEP_REQUIRE_BUILT") else pytest.skip(missing)
    files = [ROOT / "tools" / "tests" / "with_clients" / name for name in names]
    done = subprocess.run(
        [CLIENTS, "-c", _RUN, ROOT / "tools" / "src", sysconfig.get_path("purelib"),
         "-q", "-p", "no:cacheprovider", "-c", ROOT / "tools" / "pyproject.toml", *files],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    if done.returncode:
        pytest.fail(f"{done.stdout}{done.stderr}", pytrace=False)
    print(done.stdout, file=sys.stderr)
    return done.stdout
