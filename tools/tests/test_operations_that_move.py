# SPDX-License-Identifier: MIT
"""Operations on moves, homing, tables, programs and machine files: Python beside the command."""

import json

import pytest

from pixstep import formats, natives, ops
from pixstep.errors import RefusedError, UserError
from pixstep.operations import catalog, python
from pixstep.operations.asked import AskedError, FieldError, MissingError
from pixstep.operations.kinds import Flag
from pixstep.operations.request import fields
from pixstep.simulation import experiment

FAST = natives.root() / "tools/data/AccProf-fast-move.csv"
MACHINE = """\
clock.pixel = "100 Hz"
boards.main.kind = "mega"
[motors.X]
axis = 0
kind = "plain"
steps_per_unit = "400 steps/mm"
limits = { max_speed = "30 mm/s", max_acceleration = "900 mm/s2" }
[motors.Y]
axis = 1
kind = "plain"
direction = "-"
steps_per_unit = "400 steps/mm"
limits = { max_speed = "30 mm/s", max_acceleration = "900 mm/s2" }
"""
PROGRAM = "INC\nLINEAR\nTA100\nTS0\nF10\nX10 Y5\nX-4\n"
SIM = {"board": "mega", "pixel_hz": 100}
# Words, the values of fields, what the caller says of the machine.
QUICK = [
    ("move make", {"profile": FAST, "steps": 400, "pixel_hz": 30, "output": "m.csv"}, {}),
    ("move make", {"profile": FAST, "steps": "1mm", "pixel_hz": 30, "output": "m.csv"},
     {"motor": "Y"}),
    ("move show", {"profile": FAST, "steps": -4000, "pixel_hz": "30000/1001", "max_speed": 99}, {}),
    ("trajectory circle", {"radius": 400, "points": 64, "output": "made.csv"}, {}),
    ("trajectory circle", {"diameter": "1mm", "points": 64, "scale": "400 steps/mm", "holds": 0,
                           "output": "made.trj"}, {}),
    ("trajectory import", {"table": "c.csv", "output": "made.trj"}, {}),
    ("trajectory export", {"table": "c.csv", "output": "made.parquet"}, {}),
    ("trajectory compensate", {"table": "c.csv", "play": [40, 3], "transition": [8, 4],
                               "bandwidth": "none", "output": "made.csv"}, {}),
    ("trajectory compensate", {"table": "c.csv", "play": [4], "pixel_hz": 100, "bandwidth": 15.5,
                               "output": "made.csv"}, {}),
    ("trajectory show", {"table": "c.csv", "play": [4], "pixel_hz": 100, "which": "original"}, {}),
    ("plan", {"program": "p.pmc", "window": 20, "arc_tolerance": "2um"}, {"machine": "m.toml"}),
    ("plan", {"program": "p.pmc", "mode": "mode1", "assume_last": False},
     {"machine": "m.toml"}),
    ("machine new", {"board": "uno", "pixel_hz": 30, "motors": ["A:plain"], "output": "n.toml"},
     {}),
    ("machine check", {"file": "m.toml"}, {}),
    ("machine check", {"file": "wrong.toml"}, {}),
    ("machine show", {"file": "m.toml"}, {}),
]  # fmt: skip
SIMULATED = [
    ("move sim", {"profile": FAST, "steps": 300, **SIM, "axis": 2, "out": "run"}, {}),
    ("home sim", {"profile": FAST, **SIM, "plant": "home=300,hyst=8", "filter_us": 500, "slow": 3,
                  "out": "run"}, {}),
    ("home sim", {"profile": FAST, **SIM, "plant": "home=30000", "search": 200, "out": "run"}, {}),
    ("sim", {"csv": ["b.csv", "b.csv"], "decode": ["plain"], **SIM, "axis": [3, 1], "out": "run"},
     {}),
    ("sim", {"csv": ["b.csv"], "decode": ["plain"], **SIM, "divider": 2, "sync": "lock",
             "pixel_step_ppm": "100@5", "pixel_gate": "600,20", "out": "run"}, {}),
    ("trajectory sim", {"table": "c.csv", "play": [4], "transition": [4], "out": "run"},
     {"machine": "m.toml", "motor": ("X", "Y")}),
]  # fmt: skip


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    """Put files into the current folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.toml").write_text(MACHINE)
    (tmp_path / "wrong.toml").write_text(MACHINE.replace("axis = 1", "axis = 9"))
    (tmp_path / "p.pmc").write_text(PROGRAM)
    formats.write_csv(tmp_path / "b.csv", [1, 2, 3, 3, 2, 1, 0])
    ops.trajectory_circle(radius=400, points=64, revolutions=1, output="c.csv")


def _typed(words, given, machine, motor):
    """Return the command line that says the same as a call."""
    line = [*words.split(), "--json"]
    for name, field in fields(catalog.load(words)).items():
        if name not in given:
            continue
        several = given[name] if isinstance(given[name], list) else [given[name]]
        if field.argument:
            line += map(str, several)
        elif isinstance(field.kind, Flag):
            line.append(field.option)  # of these none is given as it is anyhow
        else:
            line += [f"{field.option}={value}" for value in several]
    line += [f"--machine={machine}"] if machine else []
    return line + [f"--motor={one}" for one in ((motor,) if isinstance(motor, str) else motor)]


def _compare(invoke, words, given, beside):
    caller = {"machine": "m.toml" if beside else None, "motor": (), **beside}
    made = getattr(ops, python.name_of(words))(**given, **caller)
    line = _typed(words, given, **caller)
    if any(field.writes for field in fields(catalog.load(words)).values()):
        line.append("--force")
    printed = json.loads(invoke(*line, status=made.status).stdout)
    assert printed.pop("schema") == 1
    data = json.loads(json.dumps(made.to_dict()))
    if "machine" not in data:
        printed.pop("machine", None)
    for facts in (data, printed):  # which depend on how busy this machine is
        for key in ("wall_s", "realtime_factor"):
            facts.pop(key, None)
    assert data == printed
    assert made.page() and made.fine is (made.status == 0)


@pytest.mark.usefixtures("plan_program")
@pytest.mark.parametrize(("words", "given", "beside"), QUICK)
def test_python_and_the_command_line_give_the_same(invoke, words, given, beside):
    _compare(invoke, words, given, beside)


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize(("words", "given", "beside"), SIMULATED)
def test_simulated_runs_are_the_same_from_python(invoke, words, given, beside):
    _compare(invoke, words, given, beside)


@pytest.mark.parametrize(
    ("call", "kind", "said"),
    [
        (lambda: ops.move_show(FAST, steps="1mm", pixel_hz=30), FieldError,
         "steps: distance 1mm: needs a motor's steps per mm"),
        (lambda: ops.move_show(steps=5, pixel_hz=30), MissingError, "profile: is missing"),
        (lambda: ops.move_make(FAST, steps="1mm", output="x.csv", machine="wrong.toml"),
         RefusedError, "wrong.toml:9: motors.Y.axis = 9"),
        (lambda: ops.home_sim(FAST, **SIM, plant=5, out="run"), FieldError, "plant: 5: expected"),
        (lambda: ops.trajectory_circle(radius="1mm", output="x.csv"), AskedError,
         "1mm: needs scale, or a motor of a machine file"),
        (lambda: ops.trajectory_circle(radius=1, diameter=2, output="x.csv"), AskedError,
         "a circle has diameter or radius, one of them"),
        (lambda: ops.trajectory_circle(radius=1, scale=400, output="x.csv"), FieldError,
         "scale: 400: expected a text, as 400 steps/mm"),
        (lambda: ops.trajectory_compensate("c.csv", play=4, output="x.csv"), AskedError,
         "a servo has a bandwidth in time: give pixel_hz"),
        (lambda: ops.trajectory_compensate("c.csv", play=[1, 2, 3], output="x.csv"), AskedError,
         "play is given 3 times for 2 axes"),
        (lambda: ops.trajectory_compensate("c.csv", play=40, transition=2, max_added=3,
                                           output="x.csv"), AskedError,
         "transition 2: 40 counts add more than 3 in a point"),
        (lambda: ops.trajectory_show("c.csv", play=4, bandwidth=True), FieldError,
         "bandwidth: 'True': a frequency above 0 Hz"),
        (lambda: ops.plan("p.pmc", machine="m.toml", assume_last=False), AskedError,
         "assume_last: only with mode mode1"),
        (lambda: ops.plan("p.pmc", machine="m.toml", arc_tolerance="2deg"), AskedError,
         "arc_tolerance: distance 2deg: needs a motor's steps per deg"),
        (lambda: ops.machine_new(board="uno", pixel_hz=30, motors="A", output="x.csv"), AskedError,
         "motors A: expected NAME:KIND"),
        (lambda: ops.machine_show("nowhere.toml"), UserError, "nowhere.toml: No such file"),
        (lambda: ops.sim("b.csv", decode="plain", **SIM, out="run", baud=9650), FieldError,
         "baud: 9650: a multiple of 100 is wanted"),
        (lambda: ops.sim("b.csv", decode="plain", **SIM, out="run", pixel_gate=(0, 1)), FieldError,
         "pixel_gate: '0,1': an edge at least"),
        (lambda: ops.sim("b.csv", decode="plain", **SIM, out="run", ideal="b.csv"), AskedError,
         "ideal says what the load should do: give the axis a plant too"),
        (lambda: ops.sim(["b.csv"] * 2, decode="plain", **SIM, out="run", axis=[1, 2, 3]),
         AskedError, "axis is given 3 times for 2 lines"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_in_python_s_words(tmp_path, call, kind, said):
    with pytest.raises(kind) as raised:
        call()
    assert said in str(raised.value) and "--" not in str(raised.value)
    assert not (tmp_path / "x.csv").exists() and not (tmp_path / "run").exists()


def test_pairs_may_be_numbers(monkeypatch):
    """What strays of a clock: one text on the command line, two numbers in Python."""
    seen = []
    monkeypatch.setattr(experiment, "run_job", lambda job, *_: seen.append(job) or {}["end"])
    for step, gate in (
        ("100.5@7", "600,20.5"),
        ((100.5, 7), (600, 20.5)),
        ([100.5, 7], "600,20.5"),
    ):
        with pytest.raises(KeyError):
            ops.sim("b.csv", decode="plain", **SIM, out="run", pixel_step_ppm=step, pixel_gate=gate)
    first = seen[0].flaws
    assert (first.step_ppm, first.step_edge) == (100.5, 7)
    assert (first.gate_edges, first.gate_rest_ms) == (600, 20.5)
    assert [job.flaws for job in seen] == [first] * 3


def test_a_note_comes_with_the_result():
    made = ops.move_show(FAST, steps=400, pixel_hz=100)
    assert made.notes == (
        f"{FAST}: made for 30 Hz, used at 100 Hz: its accelerations per second are 11.11 times as "
        f"high",
    )


def test_progress_is_shown_to_who_asks(monkeypatch):
    titles = []

    def shown(title):
        titles.append(title)
        raise KeyError(title)

    with pytest.raises(KeyError):
        ops.move_sim(FAST, steps=300, **SIM, out="run", progress=shown)
    assert titles == ["moving"]
