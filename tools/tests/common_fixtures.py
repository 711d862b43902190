# SPDX-License-Identifier: MIT
"""Options and fixtures of all tests: how many random lines, and what must have been built.

A test that needs a native program or an image is skipped when that is not built, unless
PIXSTEP_REQUIRE_BUILT is set (as the project's own test command does): then it fails.
"""

import functools
import gc
import json
import os
import shutil
import signal

import jsonschema
import pytest
from click.testing import CliRunner

import faultbench
from console import make_console, one, two  # noqa: F401 (fixtures)
from pixstep import natives
from pixstep.board import boards
from pixstep.cli.main import main
from pixstep.lines import core
from pixstep.operations import catalog, perform

_OBJECTS_BETWEEN_COLLECTIONS = 20_000


def pytest_addoption(parser):
    """Add --lines."""
    parser.addoption(
        "--lines", type=int, default=20, help="random lines per property test (default 20)"
    )


def pytest_configure(config):
    """Name the mark of tests that provoke faults."""
    config.addinivalue_line("markers", "provokes(*names): the faults that a test provokes")


def pytest_sessionstart():
    """Heed the signals that tests send, though a shell lets its background jobs ignore them."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


def pytest_collection_finish():
    """Let the garbage collector pass over the libraries: it takes a twentieth of the time."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(_OBJECTS_BETWEEN_COLLECTIONS)


@functools.cache
def _judge(words):
    """Return what judges an operation's result by its published schema."""
    return jsonschema.Draft202012Validator(catalog.schema(words))


@pytest.fixture(autouse=True)
def _results_judged(monkeypatch):
    """Hold every result of every test to its schema, whatever the test looks at."""
    finish = perform.finish

    def judged(request, desk):
        result = finish(request, desk)
        _judge(request.words).validate(json.loads(json.dumps(result.data)))
        return result

    monkeypatch.setattr(perform, "finish", judged)


@pytest.fixture(autouse=True)
def _provoked(request):
    """Let no test claim a fault that it has not seen."""
    marks = request.node.iter_markers("provokes")
    claimed = {name for mark in marks for name in mark.args}
    faultbench.asserted.clear()
    yield
    failed = getattr(request.node, "failed", False)
    assert failed or claimed <= faultbench.asserted, f"never seen: {claimed - faultbench.asserted}"


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item, call):
    """Keep whether a test failed or was skipped, for its fixtures."""
    report = (yield).get_result()
    item.failed = getattr(item, "failed", False) or not report.passed


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
    """Require the firmware's core as an extension."""
    _need(natives.have_made(core.LIBRARY), "the firmware's core")


@pytest.fixture(scope="session")
def simulator():
    """Require pixstep-sim and every image."""
    _need(natives.have("pixstep-sim"), "pixstep-sim")
    for board in boards.BOARD_NAMES:
        _need(natives.have_image(board), f"the {board} image")


@pytest.fixture(scope="session")
def native_board():
    """Require the firmware natively, on a pipe."""
    _need(natives.have("pixstep-native-board"), "pixstep-native-board")


@pytest.fixture(scope="session")
def libmodbus():
    """Require the client that is linked with libmodbus."""
    _need(natives.have("pixstep-libmodbus"), "pixstep-libmodbus")


@pytest.fixture(scope="session")
def fuzzers():
    """Require the fuzzers and the compiler that made them."""
    _need(natives.have("fuzz-server"), "fuzz-server")
    _need(natives.have("fuzz-board"), "fuzz-board")


@pytest.fixture(scope="session")
def mbpoll():
    """Require the Modbus client mbpoll."""
    _need(shutil.which("mbpoll") is not None, "mbpoll", "is not installed")


@pytest.fixture
def invoked():
    """Return the command that `invoke` runs."""
    return main


@pytest.fixture
def invoke(tmp_path, monkeypatch, invoked):
    """Return a function that runs a command line in an empty folder: status, output, stderr."""
    monkeypatch.chdir(tmp_path)

    def run(*words, status=0):
        done = CliRunner().invoke(invoked, [str(word) for word in words])
        assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
        assert done.exit_code == status, done.output
        return done

    return run


@pytest.fixture
def pixstep(invoke):
    """Return a function that runs a command line in an empty folder and returns its output."""
    return lambda *words, status=0: invoke(*words, status=status).output


@pytest.fixture
def put(tmp_path):
    """Return a function that writes bytes and returns the path."""

    def write(data: bytes, name: str = "x.csv"):
        path = tmp_path / name
        path.write_bytes(data)
        return path

    return write
