# SPDX-License-Identifier: MIT
"""The interface for programs: the ten lines of docs/API.md as they stand, and what they promise."""

import doctest
import importlib
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

import pixstep as px
from pixstep import natives
from pixstep.api.bus import Bus
from pixstep.board import link
from pixstep.board.device import Device
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import SimOptions

ROOT = Path(__file__).parents[2]
PRN = ROOT / "tools" / "data" / "AccProfM39-30Hz-1.PRN"
MACHINE = """\
[clock]
pixel = "30 Hz"

[boards.main]
kind = "mega"

[motors.M39]
axis = 0
kind = "smooth"
steps_per_unit = "400 steps/mm"
backlash = "250 steps"

[motors.M40]
axis = 1
kind = "plain"
direction = "-"

[motors.M40.limits]
max_acceleration = "20 steps/px2"
start_stop = "4 steps/px"
"""


@pytest.fixture
def desk(tmp_path, monkeypatch):
    """A folder with a machine file and a profile, the current one."""
    (tmp_path / "printer.toml").write_text(MACHINE)
    shutil.copy(PRN, tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def mega():
    """A simulated Mega on its line."""
    with Bus(SimLink(SimOptions([("mega", natives.image("mega"))], Fraction(30)))) as bus:
        yield bus


@pytest.mark.usefixtures("simulator", "desk")
def test_the_ten_lines_run_as_they_stand(monkeypatch, mega):
    text = (ROOT / "docs" / "API.md").read_text()
    (code,) = re.findall(r"```python\n(import pixstep as px\n.*?)```", text, re.DOTALL)
    opened = []

    def open_port(options, *_):
        opened.append(options.name)
        return mega._link

    monkeypatch.setattr(link, "open_port", open_port)
    names: dict = {}
    exec(code, names)
    run = names["run"]
    assert run.passed and str(run.axes[0].max_edge_error) in code
    assert opened == ["/dev/ttyACM0"]
    assert isinstance(run.plot_motion(), Figure)
    assert len(run.axes[0].edge_cycles) == run.axes[0].steps == names["line"].total_steps
    assert len(run.axes[0].edge_errors_ticks) == run.axes[0].expected_steps
    assert not [path for path in Path().iterdir() if path.suffix not in (".toml", ".PRN")]


@pytest.mark.usefixtures("simulator", "desk")
@pytest.mark.parametrize(
    "name", ["machines", "motions", "making", "runs", "bus", "motion", "virtual"]
)
def test_the_examples_of_the_docstrings(name):
    module = importlib.import_module(f"pixstep.api.{name}")
    done = doctest.testmod(module)
    assert not done.failed
    assert done.attempted or name == "bus"


def test_importing_loads_next_to_nothing():
    code = (
        "import sys, pixstep; names = dir(pixstep);"
        "print([name for name in sys.modules if name.startswith('pixstep.')], 'Run' in names,"
        "sys.modules.keys() & {'numpy', 'click', 'pymodbus', 'pydantic', 'matplotlib'})"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "['pixstep.version'] True set()\n"


def test_every_name_is_there_and_no_other():
    for name in px.__all__:
        assert getattr(px, name).__doc__, name
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = px.nothing


@pytest.mark.usefixtures("desk")
def test_a_motor_gives_what_is_not_said():
    machine = px.Machine.load("printer.toml")
    plain = px.line([4, -8, 2], motor=machine["M40"])
    assert (plain.line.decode, plain.pixel_hz, plain.axis) == ("plain", 30, 1)
    assert plain.check().board == "mega"
    assert "reversal_without_ramp" in [item.name for item in plain.check().errors]
    assert not px.line(plain.counts, decode="plain", pixel_hz=30).check("mega").findings
    made = px.make_line(px.read_profile(PRN), speed=8, pixels=20, motor=machine["M40"])
    assert made.counts == (-8,) * 20
    assert px.line([2, 2], motor=machine["M39"]).line.backlash == 250
    with pytest.raises(px.UserError, match="there is no motor 'M41': M39, M40"):
        machine["M41"]


@pytest.mark.usefixtures("desk")
def test_speeds_with_units():
    machine = px.Machine.load("printer.toml")
    profile = px.read_profile(PRN)
    by_length = px.make_line(profile, speed="12 mm/s", pixels=30, motor=machine["M39"], backlash=0)
    assert by_length.line.line_speed == 160
    assert px.make_line(profile, speed="3000 steps/s", pixels=30).line.line_speed == 100
    with pytest.raises(px.UserError, match=r"100 steps/s is 3.3.* nearest legal 2 .* and 4 "):
        px.make_line(profile, speed="100 steps/s", pixels=30)
    with pytest.raises(px.UserError, match="needs a pixel frequency"):
        px.make_line(px.Profile((8, 16)), speed="100 steps/s", pixels=30)


@pytest.mark.usefixtures("plan_program")
def test_refusals():
    profile = px.read_profile(PRN)
    with pytest.raises(px.RefusedError, match="made for 30 Hz, used at 300 Hz"):
        px.make_line(profile, speed=100, pixels=30, pixel_hz=300)
    wrong = px.line([2, 9, 8, 6, 2], pixel_hz=30, name="wrong")
    assert wrong.check("uno").refused
    with pytest.raises(px.RefusedError, match=r"wrong: line refused: .* at pixel 5"):
        wrong.check("uno").raise_if_refused()
    turn = px.line([1, 1, 1, -118, -118, -1], decode="plain", pixel_hz="100.13")
    assert turn.check("mega").refused and not turn.check().refused
    for call in (
        lambda: px.line([1.5]),
        lambda: px.line([1], decode="fast"),
        lambda: px.simulate(px.line([2, 2]), board="uno"),
        lambda: px.simulate(px.line([2, 2], pixel_hz=30)),
        lambda: px.simulate(px.line([2, 2], pixel_hz=30), board="nano"),
        lambda: px.simulate({1: px.line([2, 2], pixel_hz=30)}, board="uno"),
        lambda: px.simulate([], board="uno"),
        lambda: px.connect("/dev/ttyACM0", parity="X"),
        lambda: px.Profile.nearest([]),
    ):
        with pytest.raises(px.UserError) as error:
            call()
        assert "\n" not in str(error.value)


def test_numbers_of_numpy(tmp_path):
    counts = np.array([2, 6, 8, 6, 2])
    line = px.line(counts, pixel_hz=29.97)
    assert line.counts == (2, 6, 8, 6, 2) and line.pixel_hz == Fraction(2997, 100)
    assert px.read_line(line.write(tmp_path / "line.csv"), pixel_hz="29.97").counts == line.counts
    profile = px.Profile.nearest(np.linspace(10, 100, 7))
    assert profile.speeds_steps_px == (10, 24, 40, 54, 70, 84, 100)
    assert px.read_profile(profile.write(tmp_path / "own.PRN")).speeds_steps_px == (
        profile.speeds_steps_px
    )
    table = tmp_path / "own.csv"
    np.savetxt(table, np.cumsum([0, *counts]), header="position steps")
    made = px.import_line(table, quantity="position", unit="steps", pixel_hz=30)
    assert made.counts == line.counts and made.notes


@pytest.mark.usefixtures("simulator")
def test_a_failed_run_says_why():
    line = px.line([2, 9, 8, 6, 2], pixel_hz=100, name="wrong")
    run = px.simulate(line, board="uno", check=False)
    assert run.verdict == "refused" and run.axes[0].steps == 0
    assert str(run.axes[0].max_edge_error) == "unknown"
    with pytest.raises(px.RunFailedError, match="uno: refused: "):
        run.raise_if_failed()
    with pytest.raises(px.UserError, match="choose one that moved: none"):
        run.plot_motion()


@pytest.mark.usefixtures("simulator")
def test_figures_of_several_axes_and_files(tmp_path):
    lines = [px.line([2, 6, 8, 6, 2], pixel_hz=100), px.line([3, 3], decode="plain", pixel_hz=100)]
    run = px.simulate(lines, board="mega", out=tmp_path / "run").raise_if_failed()
    assert (tmp_path / "run" / "summary.json").is_file()
    every = run.plot_motion()
    assert [axes.get_ylabel() for axes in every.axes] == ["steps/s", "ticks"] * 2
    assert every._repr_png_().startswith(b"\x89PNG")
    for draw in (run.plot_motion, run.plot_edge_errors, run.plot_positions):
        assert isinstance(draw(1), Figure)
        with pytest.raises(px.UserError, match="choose one that moved: 0, 1"):
            draw(2)
    assert [row.expected_steps for row in run.axes[1].pixels] == [3, 6]


@pytest.mark.usefixtures("simulator")
def test_a_board_runs_lines_and_refuses_before_it_is_touched(mega):
    board = mega.board()
    assert (board.kind, board.pixel_hz) == ("mega", 30)
    wrong = px.line([2, 9, 8, 6, 2], pixel_hz=60)
    with pytest.raises(px.RefusedError):
        board.run(wrong)
    assert board.pixel_hz == 30
    good = px.line([2, 6, 8, 6, 2], pixel_hz=30)
    assert board.run({0: good, 2: good}) == (
        px.AxisState(0, "done", 24),
        px.AxisState(2, "done", 24),
    )
    assert [axis.position_steps for axis in board.stop()] == [24, 0, 24, 0]
    with pytest.raises(px.UserError, match="one pixel clock"):
        board.run({0: good, 1: px.line([2, 2], pixel_hz=31)})


@pytest.mark.usefixtures("simulator")
def test_an_interrupted_program_stops_the_axes(mega, monkeypatch):
    sent = []
    command = Device.command

    def noted(self, name, axes, argument=0):
        sent.append((name, axes))
        return command(self, name, axes, argument)

    def interrupted(share):
        raise KeyboardInterrupt

    monkeypatch.setattr(Device, "command", noted)
    with pytest.raises(KeyboardInterrupt) as ended:
        mega.board().run(px.line([2] * 60, decode="plain", pixel_hz=30), 1, progress=interrupted)
    assert ended.value.__notes__[0].startswith("board 1 axis 1 at position ")
    assert sent[-2:] == [("arm", [1]), ("stop", [1])]


@pytest.mark.usefixtures("simulator")
def test_a_load_with_play_and_a_waveform(tmp_path):
    line = px.line([0, 4, 8, 4, 0, -4, -8, -4, 0], decode="plain", pixel_hz=100)
    run = px.simulate(line, "uno", plant="play=3", out=tmp_path / "run", vcd=True)
    assert run.passed and (tmp_path / "run" / "run.vcd").is_file()
    loads = [row.load_steps for row in run.axes[0].pixels]
    assert loads[-1] == 3
    assert np.asarray(run.to_dataframe()["load_steps"]).tolist() == loads
    assert [axes.get_title("left") for axes in run.plot_load().axes] == [
        "Position", "Load minus ideal: largest 3 steps",
    ]  # fmt: skip
    for more, message in (
        ({"plant": {1: "play=3"}}, "plant of axis 1: it has no line"),
        ({"vcd": True}, "run.vcd needs a folder"),
    ):
        with pytest.raises(px.UserError, match=message):
            px.simulate(line, "uno", **more)
    with pytest.raises(px.UserError, match="choose one that has a plant and moved: none"):
        px.simulate(line, "uno").plot_load()
    with pytest.raises(px.UserError, match="of which axis"):
        px.simulate([line, line], "m1284", plant="play=3")


@pytest.mark.usefixtures("simulator", "desk")
def test_a_motor_of_another_board_is_refused(mega):
    machine = px.Machine.load("printer.toml")
    motor = replace(machine["M39"], board="uno")
    with pytest.raises(px.RefusedError, match="M39 is on a uno, board 1 is a mega"):
        mega.board().run(px.line([2, 6, 8, 6, 2], motor=motor))


CLOCKED = MACHINE.replace('pixel = "30 Hz"', 'pixel = "1 kHz"\ndivider = 4\nsync = "lock"')


@pytest.fixture
def clocked(desk):
    """A machine whose pixels are four edges of its clock and whose lines are locked to it."""
    (desk / "printer.toml").write_text(CLOCKED)
    return px.Machine.load("printer.toml")


@pytest.mark.usefixtures("simulator")
def test_a_locked_run_has_the_figures_of_its_clock(clocked):
    assert (clocked.pixel_hz, clocked.divider, clocked.sync) == (250, 4, "lock")
    line = px.line([20] * 60, motor=clocked["M40"], pixel_hz=250)
    # So little jitter that a few edges tell the offset, whenever the host asks for it.
    clock = px.PixelClock(ppm=3000, jitter_us=1, drop=50, double=70)
    run = px.simulate(line, clock=clock).raise_if_failed()
    assert (run.pixel_hz, run.clock.clock_hz, run.clock.divider) == (250, 1000, 4)
    assert run.clock.sync == "lock" and run.summary["clock"]["flaws"]["drop"] == 50
    assert run.clock.board_offset_ppm == pytest.approx(3000, abs=60)
    assert run.clock.board_period.ns == pytest.approx(1e6 / 1.003, abs=60)
    assert 500 < run.clock.board_jitter.ns < 4000
    assert 1 <= run.clock.board_missing <= run.clock.missing_edges
    assert 1 <= run.clock.board_glitches <= run.clock.false_edges
    found = run.axes[0].clock
    row = run.summary["axes"][0]["clock"]
    assert found.rms_error.ticks == pytest.approx(row["rms_error_ticks"], abs=0.001)
    assert found.max_error.ticks == pytest.approx(np.max(np.abs(found.errors_ticks)))
    assert list(found.pixels) == [*range(1, 61)]
    assert found.rms_error.ns < 3000 and abs(found.drift_steps) < 0.1
    titles = [axes.get_title("left") for axes in run.plot_clock().axes]
    assert titles[0].startswith("Not locked") and titles[1].startswith("Locked")


@pytest.mark.usefixtures("simulator")
def test_the_same_clock_without_the_lock(clocked):
    line = px.line([20] * 60, decode="plain", pixel_hz=250)
    world = {"board": "uno", "clock": px.PixelClock(step_ppm=10_000, step_edge=1)}
    run = px.simulate(line, divider=4, **world)
    assert (run.clock.sync, run.clock.clock_hz) == ("start", 1000)
    assert run.axes[0].clock.drift_steps == pytest.approx(20 * 59 * 0.01, rel=0.02)
    assert run.axes[0].clock.ripple.ticks == 0
    free = px.simulate(line, "uno", sync="free")
    assert free.passed and free.axes[0].clock is None and free.clock.divider == 1
    with pytest.raises(px.UserError, match="was not free: none"):
        free.plot_clock()


@pytest.mark.usefixtures("plan_program")
def test_a_line_keeps_the_divider_that_it_was_made_for(clocked):
    line = px.line([20] * 60, motor=clocked["M40"], name="scan")
    with pytest.raises(px.UserError) as error:
        px.simulate(line, divider=5)
    assert str(error.value) == (
        "scan: its pixels are 4 edges of its machine's clock, the run has 5"
    )
    with pytest.raises(px.UserError, match="scan: a line for 250 Hz, the run has 1000 Hz"):
        px.simulate(line, pixel_hz=1000)
    # A pixel of a locked line may be shorter than nominal: this one does not fit it then.
    fast = px.line([240] * 9, decode="plain", pixel_hz=250)

    def refused(**more):
        return fast.check("mega", guaranteed=False, **more).refused

    assert not refused(axes=4)
    assert refused(axes=4, sync="lock", divider=4)
    assert not refused(sync="lock", divider=4)


@pytest.mark.parametrize(
    ("made", "says"),
    [(lambda: px.PixelClock(ppm=float("nan")), "ppm nan: expected a number, -100000 to 100000"),
     (lambda: px.PixelClock(jitter_us=-1), "jitter_us -1: expected a number, 0 to 10000"),
     (lambda: px.PixelClock(drop=1), "drop 1: expected 2 or more, or 0"),
     (lambda: px.PixelClock(double=2.5), "double 2.5: expected a whole number"),
     (lambda: px.PixelClock(step_ppm=10), "step_edge 0: expected 1 or more"),
     (lambda: px.simulate(px.line([2, 2], pixel_hz=30), "uno", sync="on"),
      "sync 'on': expected one of free, start, lock"),
     (lambda: px.simulate(px.line([2, 2], pixel_hz=30), "uno", divider=1001),
      "divider 1001: expected a whole number, 1 to 1000")],
)  # fmt: skip
def test_clocks_that_cannot_be(made, says):
    with pytest.raises(px.UserError, match=re.escape(says)):
        made()


@pytest.mark.usefixtures("simulator")
def test_a_board_gets_the_clock_of_the_lines(clocked):
    with Bus(SimLink(SimOptions([("mega", natives.image("mega"))], Fraction(1000)))) as bus:
        board = bus.board()
        line = px.line([2] * 60, motor=clocked["M40"])
        (state,) = board.run(line)
        assert (state.state, state.position_steps, board.pixel_hz) == ("done", 120, 250)
        names = ("sync", "divider", "pixel_hz_num")
        assert [board.device.setting(name) for name in names] == [2, 4, 1000]
        own = px.line([2] * 30, decode="plain", pixel_hz=500)
        assert board.run(own, sync="start", divider=2)[0].state == "done"
        assert [board.device.setting(name) for name in names] == [1, 2, 1000]
        with pytest.raises(px.UserError, match="the run has 2"):
            board.run(line, divider=2)
