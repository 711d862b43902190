# SPDX-License-Identifier: MIT
"""The first use of a name of the interface is quick: it loads nothing that takes long to load."""

import json
import os
import subprocess
import sys

import pytest

import pixstep as px

MOST_S = 0.15  # of processor time
SLOW = {
    "_cffi_backend", "asyncio", "cffi", "click", "matplotlib", "numpy", "pandas", "pyarrow",
    "pydantic", "pymodbus", "rich", "serial", "tomlkit",
}  # fmt: skip
USE = """
import json, sys, time
began = time.process_time()
import pixstep
pixstep.{}
seconds = time.process_time() - began
print(json.dumps([seconds, sorted(name.partition(".")[0] for name in sys.modules)]))
"""
TRIES = 4  # a busy machine makes a process take longer


@pytest.fixture(scope="module")
def environment(tmp_path_factory):
    """Return an environment in which byte code is kept, as an installation has it."""
    kept = os.environ.get("PYTHONPYCACHEPREFIX") or str(tmp_path_factory.mktemp("kept"))
    made = os.environ | {"PYTHONPYCACHEPREFIX": kept, "PYTHONDONTWRITEBYTECODE": ""}
    for name in ("simulate", "connect", "read_program"):
        use(name, made)
    return made


def use(name, environment):
    """Use a name in a process of its own; return its processor time and the packages loaded."""
    done = subprocess.run(
        [sys.executable, "-c", USE.format(name)],
        env=environment, capture_output=True, text=True, check=True,
    )  # fmt: skip
    seconds, packages = json.loads(done.stdout)
    return seconds, set(packages)


@pytest.mark.parametrize("name", px.__all__)
def test_a_name_is_there_at_once(name, environment):
    for _ in range(TRIES):
        seconds, packages = use(name, environment)
        assert packages & SLOW == set()
        if seconds < MOST_S:
            return
    pytest.fail(f"{name}: {seconds:.3f} s of processor time")
