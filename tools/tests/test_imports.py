# SPDX-License-Identifier: MIT
"""Importing the product: on any system, and without a change of the program that imports it."""

import subprocess
import sys

import pytest

ALL = """
import importlib, pkgutil
import pixstep
names = [one.name for one in pkgutil.walk_packages(pixstep.__path__, "pixstep.")]
def import_all():
    for name in names:
        if not name.endswith("__main__"):
            importlib.import_module(name)
"""
# The modules of other packages still get what this system has: theirs is their own business.
WITHOUT = """
import builtins, signal
real, missing = builtins.__import__, {"termios", "fcntl", "pty", "tty", "resource", "pwd", "grp"}
def restricted(name, globals=None, *more, **options):
    asking = (globals or {}).get("__name__", "")
    if name in missing and asking.partition(".")[0] in ("pixstep", "late"):
        raise ImportError(f"{asking}: no module named {name}", name=name)
    return real(name, globals, *more, **options)
builtins.__import__ = restricted
del signal.SIGHUP
"""
STATE = """
import logging, signal, sys, warnings
import matplotlib
loggers = [logging.getLogger(name) for name in (None, "pixstep", "matplotlib")]
def state():
    return {
        "drawing": matplotlib.rcParams.copy(),  # reading an item may load a backend
        "logging": [(one.level, list(one.handlers), one.disabled) for one in loggers],
        "warnings": list(warnings.filters),
        "signals": [signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM)],
        "pyplot": "matplotlib.pyplot" in sys.modules,
    }
def changed():
    return [name for name, value in state().items() if value != before[name]]
before = state()
"""


def run(code):
    """Run a program; return what it printed, or its last words."""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    return done.stdout if done.returncode == 0 else done.stderr.splitlines()[-1]


def test_every_module_is_imported_where_there_are_no_terminals_and_no_sighup():
    assert int(run(f"{WITHOUT}{ALL}import_all(); print(len(names))")) > 100


@pytest.mark.parametrize("name", ["termios", "fcntl"])
def test_an_unguarded_import_is_found(name):
    late = f"exec('import {name}', {{'__name__': 'late'}})"
    assert run(f"{WITHOUT}{late}") == f"ImportError: late: no module named {name}"


def test_an_import_changes_nothing_of_the_program_around_it():
    assert run(f"{STATE}{ALL}import_all(); print(changed())") == "[]\n"


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ("matplotlib.use('svg')", "drawing"),
        ("logging.getLogger('pixstep').setLevel('CRITICAL')", "logging"),
        ("logging.basicConfig()", "logging"),
        ("warnings.simplefilter('ignore')", "warnings"),
        ("signal.signal(signal.SIGTERM, signal.SIG_IGN)", "signals"),
        ("import matplotlib.pyplot", "pyplot"),
    ],
)
def test_a_change_on_import_is_found(change, name):
    assert name in run(f"{STATE}{change}; print(changed())")
