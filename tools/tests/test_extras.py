# SPDX-License-Identifier: MIT
"""What is not installed: an extra that a command or a call needs is named in one line."""

import re
import shutil
import subprocess
import sys
import tomllib

import pytest

from pixstep import natives
from pixstep.lazy import lazy, missing_package

CLONE = " (in a clone: tools/setup)"
PROFILE = natives.example("AccProfM39-30Hz-1.PRN")
# A process in which some packages are not installed.
WITHOUT = """
import importlib, pkgutil, sys
for name in {}:
    sys.modules[name] = None
"""
MODULES = """
import pixstep
refused = []
for one in pkgutil.walk_packages(pixstep.__path__, "pixstep."):
    try:
        if not one.name.endswith("__main__"):
            importlib.import_module(one.name)
    except (ModuleNotFoundError, pixstep.UserError) as error:
        refused.append(one.name)
print(*refused)
"""
COMMAND = """
from pixstep.__main__ import run
run()
"""
DRAWINGS = {
    "fly.picture", "moves.plots", "plotting", "profiles.figure",
    "programs.figure", "reversals.picture", "simulation.plots", "trajectories.picture",
}  # fmt: skip
MACHINE = """
clock.pixel = "30 Hz"
boards.main.kind = "mega"
motors.m1 = { axis = 0, kind = "smooth" }
"""
LINE = ("line.csv", "--decode", "smooth", "--pixel-hz", "30")
MAKE = (
    "line", "make", "--profile", str(PROFILE), "--speed", "1000", "--pixels", "60",
    "--pixel-hz", "30", "-o", "line.csv",
)  # fmt: skip


def run(code, without, folder, *words):
    """Run a program without some packages."""
    return subprocess.run(
        [sys.executable, "-c", WITHOUT.format(without) + code, *words],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip


@pytest.fixture(scope="module")
def line(tmp_path_factory):
    """Return a line file, made without any extra."""
    folder = tmp_path_factory.mktemp("made")
    done = run(COMMAND, ["numpy", "matplotlib", "pyarrow"], folder, *MAKE)
    assert done.returncode == 0, done.stderr
    return folder / "line.csv"


def test_only_drawings_need_matplotlib(tmp_path):
    done = run(MODULES, ["matplotlib", "pyarrow", "pandas"], tmp_path)
    assert {name.removeprefix("pixstep.") for name in done.stdout.split()} == DRAWINGS


def test_only_the_server_of_records_needs_caproto(tmp_path):
    done = run(MODULES, ["caproto"], tmp_path)
    assert {name.removeprefix("pixstep.") for name in done.stdout.split()} == {
        f"ioc.{name}" for name in ("channels", "motors", "server")
    }


def test_records_need_caproto_and_their_list_does_not(tmp_path):
    (tmp_path / "machine.toml").write_text(MACHINE)
    done = run(COMMAND, ["caproto"], tmp_path, "ioc", "--simulate")
    assert done.returncode == 2
    assert done.stderr == f"pixstep: EPICS needs caproto: pip install 'pixstep[epics]'{CLONE}\n"
    assert run(COMMAND, ["caproto"], tmp_path, "ioc", "--list").returncode == 0


def test_only_drawings_and_programs_need_numpy_at_once(tmp_path):
    done = run(MODULES, ["matplotlib", "numpy", "pyarrow", "pandas"], tmp_path)
    refused = {name.removeprefix("pixstep.") for name in done.stdout.split()}
    assert refused > DRAWINGS
    assert {name for name in refused - DRAWINGS if not name.startswith("programs.")} == set()


@pytest.mark.parametrize(
    "words",
    [
        ("line", "check", *LINE, "--board", "mega"),
        ("line", "show", *LINE),
        ("ticks", *LINE, "-o", "ticks.csv"),
        ("ticks", *LINE, "--pixels", "-o", "pixels.csv"),
        ("file", "info", "line.csv"),
        ("profile", "show", str(PROFILE)),
        ("limits", "--board", "mega", "--pixel-hz", "200"),
        ("machine", "new", "--board", "mega", "--pixel-hz", "30"),
    ],
)
def test_files_and_plans_need_no_extra(tmp_path, line, words):
    shutil.copy(line, tmp_path)
    done = run(COMMAND, ["numpy", "matplotlib", "pyarrow"], tmp_path, *words)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("without", "words", "extra"),
    [
        (["matplotlib"], ("line", "show", *LINE, "--plot", "line.png"), "plot"),
        (["matplotlib"], ("sim", *LINE, "--board", "mega", "--out", "run", "--plot"), "plot"),
        (["numpy"], ("sim", *LINE, "--board", "mega", "--out", "run"), "numpy"),
        (["numpy"], ("demo", "--out", "run"), "numpy"),
        (["numpy"], ("trajectory", "circle", "--radius", "3200", "-o", "circle.trj"), "numpy"),
    ],
)  # fmt: skip
def test_what_is_missing_is_named_before_anything_is_done(tmp_path, line, without, words, extra):
    shutil.copy(line, tmp_path)
    done = run(COMMAND, without, tmp_path, *words)
    assert done.returncode == 2
    assert re.fullmatch(
        rf"pixstep: .* pip install 'pixstep\[{extra}\]'{re.escape(CLONE)}\n", done.stderr
    )
    assert [path.name for path in tmp_path.iterdir()] == ["line.csv"]


CALLS = """
import pixstep as px
try:
    {}
except px.UserError as error:
    print(error)
"""


@pytest.mark.parametrize(
    ("call", "extra"),
    [
        ("px.line((2, 4, 4, 2)).plot()", "plot"),
        ("px.simulate(px.line((2, 4, 4, 2)), board='mega', pixel_hz=30)", "numpy"),
        ("from pixstep.api import motion; motion.np.zeros(1)", "numpy"),
    ],
)  # fmt: skip
def test_a_call_says_what_is_missing(tmp_path, call, extra):
    done = run(CALLS.format(call), ["numpy", "matplotlib"], tmp_path)
    assert done.stdout.endswith(f"pip install 'pixstep[{extra}]'{CLONE}\n"), done.stderr


def test_another_missing_module_is_an_error_as_ever(tmp_path):
    assert missing_package(ModuleNotFoundError("No module", name="secrets")) is None
    with pytest.raises(ModuleNotFoundError, match="no_such_module"):
        _ = lazy("no_such_module").anything


@pytest.mark.parametrize("package", ["numpy", "matplotlib", "pyarrow", "caproto", "distributed"])
def test_the_extra_that_is_named_brings_the_package(package):
    project = tomllib.loads(natives.source("pyproject.toml").read_text())["project"]
    error = missing_package(ModuleNotFoundError("No module", name=f"{package}.part"))
    (extra,) = re.findall(rf"pip install 'pixstep\[(\w+)\]'{re.escape(CLONE)}$", str(error))
    brought = project["optional-dependencies"][extra]
    assert package in {re.match(r"[\w-]+", text)[0] for text in brought}
    assert package not in {re.match(r"[\w-]+", text)[0] for text in project["dependencies"]}
