# SPDX-License-Identifier: MIT
"""Whatever `line check` refuses is refused wherever lines are run, in the same words."""

import json
import random
from fractions import Fraction
from pathlib import Path

import pytest
from click.testing import CliRunner

import pixstep as px
from console import PORT, put
from pixstep import formats
from pixstep.cli.main import main
from pixstep.formats import ProfileHeader
from pixstep.lines import units
from pixstep.machine import describe, files

MACHINE = f"""\
[clock]
pixel = 30
[line]
lead_in = 2
motor = "M39"
[boards.main]
kind = "mega"
port = "{PORT}"
[motors.M39]
axis = 0
kind = "smooth"
steps_per_unit = "400 steps/mm"
limits = {{ max_speed = "40 steps/px", max_acceleration = "20 steps/px2" }}
[motors.M40]
axis = 1
kind = "plain"
limits = {{ max_speed = "40 steps/px", max_acceleration = "20 steps/px2", start_stop = 4 }}
[motors.mirror]
axis = 2
kind = "smooth"
"""
MOTOR = {"smooth": "M39", "plain": "M40"}
LINES = {  # what is wrong with them: decode rule, counts
    "speed": ("smooth", [10, 20, 28, 28, 20, 10]),
    "acceleration": ("smooth", [16, 32, 32, 16]),
    "oscillates": ("smooth", [8, 20, 20, 20, 8]),
    "plain speed": ("plain", [20, 40, 41, 40, 20]),
    "plain acceleration": ("plain", [23, 23]),
    "reversal": ("plain", [10, -10]),
    "negative": ("smooth", [-2, -4, -2]),
    "board": ("plain", [16000]),
}


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Put a machine into the current folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("PIXSTEP_PORT", raising=False)
    Path("machine.toml").write_text(MACHINE)
    return tmp_path


@pytest.mark.parametrize("wrong", LINES)
def test_one_judgement(here, one, invoke, wrong):
    decode, counts = LINES[wrong]
    put(counts, "line.csv")
    motor = ("--motor", MOTOR[decode])
    found = json.loads(invoke("line", "check", "line.csv", *motor, "--json", status=3).stdout)
    first = next(item for item in found["findings"] if item["severity"] == "error")
    said = f"line.csv: line refused: {first['name']} at pixel {first['pixel']}: {first['message']}"
    assert said in invoke("sim", "line.csv", *motor, status=3).stderr
    assert not Path("run").exists()
    assert said in one.err("upload", "line.csv", *motor, status=3)
    assert not any(axis.next_block for axis in one.board.axes)
    machine = px.Machine.load("machine.toml")
    line = px.read_line("line.csv", motor=machine[MOTOR[decode]])
    with pytest.raises(px.RefusedError) as refused:
        px.simulate(line)
    assert str(refused.value) == said
    with px.connect(PORT) as bus, pytest.raises(px.RefusedError) as refused:
        bus.board(1).run(line)
    assert str(refused.value) == said


# Rounded positions: what `plan` makes within a motor's limits is what every other command takes.
@pytest.mark.usefixtures("simulator")
def test_whole_steps_of_a_plain_motor_may_change_by_two_more(here, one, invoke):
    put([22, 22, 0], "line.csv")
    motor = ("--motor", MOTOR["plain"])
    invoke("line", "check", "line.csv", *motor)
    asked = invoke("line", "check", "line.csv", *motor, "--max-acceleration", "20", status=3).stdout
    assert "acceleration 22 is above 20" in asked
    assert "PASS" in invoke("sim", "line.csv", *motor).stdout
    assert "loaded" in one.out("upload", "line.csv", *motor)
    line = px.read_line("line.csv", motor=px.Machine.load("machine.toml")["M40"])
    assert px.simulate(line).passed


@pytest.mark.usefixtures("simulator")
def test_no_check_is_the_one_way_past_it(here, one, invoke):
    decode, counts = LINES["acceleration"]
    put(counts, "line.csv")
    assert "PASS" in invoke("sim", "line.csv", "--no-check").stdout
    assert "loaded" in one.out("upload", "line.csv", "--no-check")
    line = px.read_line("line.csv", motor=px.Machine.load("machine.toml")[MOTOR[decode]])
    assert px.simulate(line, check=False).passed


def test_a_line_for_a_slower_clock(here, one, invoke):
    header = ProfileHeader("Thu Nov 26 17:00:00 2026", "slow", 1, 0, 0, "25")
    formats.write_csv(Path("line.csv"), [2, 4, 2], header)
    said = "line.csv: made for 25 Hz, used at 30 Hz: its accelerations per second are 1.44 times as"
    for words in (("line", "check"), ("sim",)):
        assert said in invoke(*words, "line.csv", status=3).stderr
    assert said in one.err("upload", "line.csv", status=3)
    motor = px.Machine.load("machine.toml")["M39"]
    with pytest.raises(px.RefusedError, match="made for 25 Hz, used at 30 Hz"):
        px.read_line("line.csv", motor=motor)
    assert said in px.read_line("line.csv", motor=motor, check=False).notes[-1]
    assert f"note: {said}" in one.run("upload", "line.csv", "--no-check").stderr


# Negative counts, other motors, lead-ins, the board that is assumed


@pytest.mark.parametrize("backlash", [0, 5])
def test_negative_counts_are_named_whatever_the_backlash(here, invoke, backlash):
    put([0, -2, -4, -2, 0], "line.csv")
    words = ("line", "check", "line.csv", "--decode", "smooth", "--backlash", backlash, "--json")
    found = json.loads(invoke(*words, status=3).stdout)["findings"]
    errors = [item for item in found if item["severity"] == "error"]
    assert (errors[0]["name"], errors[0]["pixel"]) == ("negative_count", 2)
    assert any(item["name"] == "idle_pixel" for item in found) is (backlash == 0)


OTHER = "made for motor M39, used for motor M40"


@pytest.mark.parametrize(
    "words",
    [
        ("line", "make", "--profile", "AccProfM39-30Hz-1.PRN", "--speed", "3", "--pixels", "9",
         "-o", "x.csv"),
        ("profile", "show", "AccProfM39-30Hz-1.PRN"),
        ("profile", "check", "AccProfM39-30Hz-1.PRN"),
        ("line", "check", "AccProfM39-30Hz-1.CSV"),
        ("line", "show", "named.csv"),
        ("line", "check", "named.csv"),
        ("sim", "named.csv", "--no-check"),
        ("ticks", "named.csv", "-o", "t.csv"),
        ("move", "show", "named.csv", "--steps", "10"),
        ("move", "make", "AccProfM39-30Hz-1.CSV", "--steps", "10", "-o", "m.csv"),
        ("home", "sim", "named.csv", "--plant", "home=300", "--haps", "1"),
        ("board", "upload", "named.csv"),
        ("board", "move", "named.csv", "--steps", "10"),
    ],
    ids=" ".join,
)  # fmt: skip
def test_what_is_made_for_another_motor_is_said(here, one, words):
    formats.write_prn(Path("AccProfM39-30Hz-1.PRN"), [2, 4])
    put([2, 4], "AccProfM39-30Hz-1.CSV")
    force = ("--force",) if "-o" in words else ()
    for name in ("AccProfM39-30Hz-1", "M39"):
        header = ProfileHeader("Thu Nov 26 17:00:00 2026", name, 1, 0, 0, "30")
        formats.write_csv(Path("named.csv"), [2, 4], header)
        done = _finish(*words, "--motor", "M40", *force)
        assert OTHER in done.stderr, done.output
        done = _finish(*words, "--motor", "M39", *force)
        assert "made for motor" not in done.stderr
        one.out("disarm")


def test_a_lead_in_that_the_machine_does_not_have(here, one, invoke):
    for lead_in in (4, 2, 0):
        header = ProfileHeader("Thu Nov 26 17:00:00 2026", "scan", 1, 0, lead_in, "30")
        formats.write_csv(Path("line.csv"), [2, 4, 2], header)
        said = (
            "note: line.csv: its header has LeadIn 4, machine.toml has lead_in = 2 in the table "
            "[line]: the image begins at another pixel\n"
        )
        for done in (invoke("line", "check", "line.csv"), one.run("upload", "line.csv")):
            assert (said in done.stderr) is (lead_in == 4)
        one.out("disarm")


def test_the_board_that_is_assumed_is_said(here, invoke):
    put([2, 4, 2], "line.csv")
    words = ("line", "check", "line.csv", "--decode", "smooth", "--machine", "none")
    said = "note: line.csv: checked by what the Arduino Uno can do (--board)\n"
    assert said in invoke(*words, "--pixel-hz", "30").stderr
    assert said not in invoke(*words, "--pixel-hz", "30", "--board", "uno").stderr
    assert said not in invoke(*words).stderr
    for more, board in ((("--pixel-hz", "30"), "uno"), ((), None)):
        assert json.loads(invoke(*words, *more, "--json").stdout)["board"] == board


# Names of motors


@pytest.mark.parametrize("name", ["mirror", "X", "a-b_7", "Spiegel ä", 'say "x"', "M39-30Hz-1"])
def test_any_name_of_a_motor(here, invoke, name):
    words = ("--board", "mega", "--pixel-hz", "30", "--motor", f"{name}:smooth", "-o", "new.toml")
    invoke("machine", "new", *words)
    machine = px.Machine.load("new.toml")
    assert machine[name].decode == "smooth"
    given = ("--machine", "new.toml", "--motor", name)
    invoke("profile", "make", "--variant", "1", "--max-jerk", "40", *given)
    path = Path(f"AccProf{name}-30Hz-1.PRN")
    assert path.is_file() and f"AccProf{name}-30Hz-1.PRN".replace('"', '\\"') in Path(
        "new.toml"
    ).read_text(encoding="utf-8")
    made = ("line", "make", "--profile", path, "--speed", "12mm/s", "-o", "line.csv", "--force")
    assert "made for" not in invoke(*made, *given).stderr
    checked = json.loads(invoke("profile", "check", path, "--json", *given).stdout)
    assert {row["decode"] for row in checked["readings"]} == {"smooth"}


def test_a_name_that_no_file_can_have(here, invoke):
    invoke("machine", "new", "--board", "mega", "--pixel-hz", "30", "--motor", "a/b:plain",
           "-o", "new.toml")  # fmt: skip
    assert px.Machine.load("new.toml")["a/b"].decode == "plain"
    said = invoke("profile", "make", "--motor", "a/b", "--variant", "1", "--top-speed", "10",
                  "--max-jerk", "4", "--max-acceleration", "8", status=2).stderr  # fmt: skip
    assert "motor 'a/b': its name cannot be a part of a file's name" in said


# Pixels that are too short for a limit

CLOCKS = [
    "30", "0.96", "316.2", "317", "1 kHz", "2500", "5 kHz", "15625", "30000/1001", "8 kHz",
]  # fmt: skip


@pytest.mark.parametrize("hz", CLOCKS)
@pytest.mark.parametrize("kind", ["smooth", "plain"])
def test_a_new_machine_is_fine_at_any_clock(here, invoke, hz, kind):
    new = ("machine", "new", "--board", "mega", "--pixel-hz", hz, "--motor", f"M:{kind}", "--force")
    invoke(*new)
    assert "machine.toml: fine" in invoke("machine", "check").stdout
    invoke("limits")
    invoke(
        "profile", "make", "--variant", "1", "--max-jerk", "2steps/px3", "--motor", "M", "--force"
    )


def test_a_new_machine_is_fine_at_random_clocks():
    chance = random.Random(41)
    for _ in range(60):
        hz = Fraction(round(10 ** chance.uniform(0, 4.19), 3)).limit_denominator(1000)
        board = chance.choice(["uno", "mega", "m1284"])
        sync = chance.choice([None, "start", "free"])
        text = files.new_text(board, hz, {"A": chance.choice(["smooth", "plain"])}, None, sync)
        assert not list(describe.warnings(files.parse(text))), (board, hz, sync)


@pytest.mark.parametrize(("divider", "acceleration"), [(1, 5000), (2, 1300), (4, 500), (9, 500)])
def test_a_divider_that_is_asked_for_stays(here, invoke, divider, acceleration):
    words = ("machine", "new", "--board", "mega", "--clock-hz", "1 kHz", "--divider", divider)
    invoke(*words, "--force")
    machine = px.Machine.load("machine.toml")
    assert machine.divider == divider
    assert f'max_acceleration = "{acceleration} mm/s2"' in Path("machine.toml").read_text()
    assert "machine.toml: fine" in invoke("machine", "check").stdout


def test_a_clock_that_no_board_follows(here, invoke):
    new = ("machine", "new", "--board", "mega", "--force", "--pixel-hz")
    for hz in ("0.9", "20 kHz"):
        said = invoke(*new, hz, status=2).stderr
        assert "the period must be 1024 to 16777215 ticks\n" in said
    assert Path("machine.toml").read_text() == MACHINE


KHZ = MACHINE.replace("pixel = 30", 'pixel = "1 kHz"').replace(
    "20 steps/px2", "500 mm/s2"
).replace('kind = "plain"', 'kind = "plain"\nsteps_per_unit = "400 steps/mm"')  # fmt: skip


@pytest.mark.parametrize(
    ("words", "edges"),
    [
        (("machine", "check"), 4),
        (("limits",), 4),
        (("limits", "--motor", "M40"), 4),
        (("line", "check", "line.csv", "--backlash", "0"), 4),
        (("line", "check", "line.csv", "--motor", "M40"), 3),
        (("sim", "line.csv"), 4),
        (("profile", "make", "--variant", "1", "--max-jerk", "8", "--top-speed", "8"), 4),
        (("limits", "--max-acceleration", "200 mm/s2"), 5),
        (("limits", "--max-jerk", "100 mm/s3"), 37),
        (("limits", "--max-speed", "0.5 mm/s"), 10),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else str(value),
)
def test_the_divider_that_would_do_is_named(here, invoke, words, edges):
    """One edge less would not do, as the same command says."""
    Path("machine.toml").write_text(KHZ)
    put([2, 4, 2], "line.csv")

    def told(divider):
        Path("machine.toml").write_text(KHZ.replace("[line]", f"divider = {divider}\n[line]"))
        done = _finish(*words)
        return done.stdout + done.stderr

    assert f"divider = {edges} in the table [clock]" in told(1)
    assert f"divider = {edges} in the table [clock]" in told(edges - 1)
    assert "would do" not in told(edges) and "at least" not in told(edges).split("Shortest")[0]


def _finish(*words):

    return CliRunner().invoke(main, [str(word) for word in words])


def test_the_fewest_edges_are_exact():
    chance = random.Random(7)
    for _ in range(300):
        order = chance.choice([units.SPEED, units.ACCELERATION, units.JERK])
        value = Fraction(chance.randrange(1, 10**9), chance.randrange(1, 100))
        limit = units.Quantity(value, order, True, "x")
        hz, least = Fraction(chance.randrange(1, 10**6), 100), chance.choice([1, 2])
        edges = units.enough_edges(limit, hz, least)
        assert limit.per_pixel(hz / edges) >= least
        assert edges == 1 or limit.per_pixel(hz / (edges - 1)) < least
