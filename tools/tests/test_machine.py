# SPDX-License-Identifier: MIT
"""Machine files: what they hold, and every mistake with its line, key and value."""

import json
from fractions import Fraction

import pytest

from pixstep import tomltext
from pixstep.board import boards
from pixstep.errors import UserError
from pixstep.machine import files
from pixstep.machine.files import MachineFile

GOOD = """\
[clock]
pixel = "30000/1001 Hz"

[line]
motor = "M39"
pixels = 60

[boards.main]
kind = "mega"
port = "/dev/ttyACM0"

[motors.M39]
axis = 0
kind = "smooth"
steps_per_unit = "2.5 um/step"
direction = "-"
backlash = "25 um"
profiles.line = "AccProfM39-30Hz-1.PRN"
limits = { max_speed = "30 mm/s", max_acceleration = "128 steps/px2" }

[motors.M40]
axis = 2
kind = "plain"
"""


@pytest.fixture
def machine(put):
    """Return a function that reads a machine file of a text."""
    return lambda text: MachineFile.load(put(text.encode(), "machine.toml"))


def test_values_are_exact_and_in_steps(machine, tmp_path):
    made = machine(GOOD)
    motor = made["M39"]
    assert made.pixel_hz == Fraction(30000, 1001)
    assert str(motor.steps_per_unit) == "400 steps/mm"
    assert (motor.backlash_steps, motor.negative, motor.smooth) == (10, True, True)
    assert motor.limit("max_speed").per_pixel(made.pixel_hz) == 12000 / made.pixel_hz
    assert motor.limit("max_acceleration").per_pixel(None) == 128
    assert motor.limit("max_jerk") is None
    assert made.profile(motor, "line") == tmp_path / "AccProfM39-30Hz-1.PRN"
    assert made.board_of(made["M40"]).kind == "mega" and made["M40"].backlash_steps == 0
    assert made.default_motor() is motor
    with pytest.raises(UserError, match=r"there is no motor 'M7': M39, M40$"):
        made["M7"]


def test_the_motor_of_lines_is_the_only_one_or_named(machine):
    several = GOOD.replace('motor = "M39"\n', "")
    with pytest.raises(UserError, match="has motors M39, M40: choose by motor, or"):
        machine(several).default_motor()
    alone = several[: several.index("[motors.M40]")]
    assert machine(alone).default_motor().name == "M39"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("30000/1001 Hz", "30 Hzz", "2: clock.pixel = '30 Hzz': pixel frequency '30 Hzz': "),
        ('pixel = "30000/1001 Hz"', "", "1: clock.pixel: is missing"),
        ("pixels = 60", "pixels = 4.5", "6: line.pixels = 4.5: '4.5': expected a whole number"),
        ("pixels = 60", "pixels = 0", "6: line.pixels = 0: expected greater than or equal to 1"),
        ('"M39"', '"M3"', "5: line.motor = 'M3': there is no motor of this name: M39, M40"),
        ('"mega"', '"megaa"', "9: boards.main.kind = 'megaa': expected one of uno, mega"),
        ("port =", "prt =", "10: boards.main.prt = '/dev/ttyACM0': unknown key"),
        ("axis = 0", "axis = true", "13: motors.M39.axis = True: expected a valid integer"),
        ("axis = 2", "axis = 4", "22: motors.M40.axis = 4: mega has 4 axes: 0 to 3"),
        ("axis = 2", "axis = 0", "22: motors.M40.axis = 0: motor M39 has this axis"),
        ('"plain"', '"plane"', "23: motors.M40.kind = 'plane': expected 'smooth' or 'plain'"),
        ('"plain"', '"plain"\nboard = "b"', "24: motors.M40.board = 'b': there is no board"),
        ('"plain"', '"plain"\nname = "x"', "24: motors.M40.name = 'x': its name is that of"),
        ("um/step", "mm", "15: motors.M39.steps_per_unit = '2.5 mm': expected steps per length"),
        ("um/step", "deg/step", "17: motors.M39.backlash = '25 um': distance 25 um: needs a"),
        ("25 um", "3 um", "17: motors.M39.backlash = '3 um': distance 3 um is 1.2 steps, not a"),
        ("30 mm/s", "30 mm/s2", "19: motors.M39.limits.max_speed = '30 mm/s2': speed '30 mm/s2'"),
        ("[clock]", "[clokc]", "1: clokc: unknown key"),
        ("[clock]", "clock = 3\n[x]", "1: clock = 3: expected a valid dictionary"),
        ("[clock]", "[clock]\ndivider = 0", "2: clock.divider = 0: expected greater than or equal"),
        ("[clock]", "[clock]\ndivider = 1001", "2: clock.divider = 1001: expected less than or eq"),
        ("[clock]", "[clock]\ndivider = 2.5", "2: clock.divider = 2.5: expected a valid integer"),
        ("[clock]", "[clock]\ndivider = '4'", "2: clock.divider = '4': expected a valid integer"),
        ("[clock]", "[clock]\nsync = 'on'",
         "2: clock.sync = 'on': expected 'free', 'start' or 'lock'"),
        ("[clock]", "[clock]\nsync = 2", "2: clock.sync = 2: expected 'free', 'start' or 'lock'"),
    ],
)  # fmt: skip
def test_a_mistake_is_named_by_line_key_and_value(put, old, new, message):
    path = put(GOOD.replace(old, new, 1).encode(), "m.toml")
    assert any(text.startswith(f"{path}:{message}") for text in files.problems(path))
    with pytest.raises(UserError, match=r"^[^\n]*$"):
        MachineFile.load(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[clock\n", r"m.toml:1:7: "),
        ("x = " + "[" * 2000, "nested too deeply"),
        ("a = 1\nx = " + "1" * 5000, "m.toml:2: a number has too many digits"),
        ("", "boards: is missing"),
    ],
)
def test_what_is_no_machine_at_all(put, text, message):
    with pytest.raises(UserError, match=message):
        MachineFile.load(put(text.encode(), "m.toml"))


def test_a_missing_file_and_strange_bytes(put, tmp_path):
    with pytest.raises(UserError, match="No such file"):
        MachineFile.load(tmp_path / "none.toml")
    with pytest.raises(UserError, match="not UTF-8 at byte 2"):
        MachineFile.load(put(b"a=\xff", "m.toml"))


def test_two_boards_need_places_and_motors_say_which(machine, put):
    two = GOOD.replace(
        "[motors.M39]", '[boards.other]\nkind = "uno"\nport = "/dev/ttyACM0"\n[motors.M39]', 1
    )
    problems = files.problems(put(two.encode(), "two.toml"))
    assert [text.split(": ", 2)[1:] for text in problems] == [
        ["boards.other.unit", "board main has this address on this port"],
        ["motors.M39", "needs a key board, one of main, other"],
        ["motors.M40", "needs a key board, one of main, other"],
    ]


def test_two_boards_without_ports_cannot_have_one_address(put):
    text = '[clock]\npixel = 30\n[boards.a]\nkind = "mega"\n[boards.b]\nkind = "uno"\n'
    text += 'unit = UNIT\n[motors.X]\nboard = "a"\naxis = 0\nkind = "plain"\n'
    path = put(text.replace("UNIT", "1").encode(), "two.toml")
    assert files.problems(path) == [
        f"{path}:7: boards.b.unit = 1: board a has this address too, and neither "
        "has a port of its own"
    ]
    assert not files.problems(put(text.replace("UNIT", "2").encode(), "two.toml"))


NESTED = """\
top = 1 # a comment

[a.b]
c = 1
d.e = 2
f = { g = 3, h = "i" }
k = [
  1,
]
[[l]]
m = 1
[[l]]
m = 2
"""


@pytest.mark.parametrize(
    ("keys", "line"),
    [
        (["top"], 1), (["a", "b"], 3), (["a", "b", "c"], 4), (["a", "b", "d", "e"], 5),
        (["a", "b", "f"], 6), (["a", "b", "f", "h"], 6), (["a", "b", "k"], 7), (["l", 0, "m"], 11),
        (["l", 1], 12), (["l", 1, "m"], 13), (["a"], None), (["nothing"], None), (["l", 7], None),
    ],
)  # fmt: skip
def test_the_line_of_a_key(keys, line):
    assert tomltext.line_of(NESTED, keys) == line
    assert tomltext.line_of(NESTED.replace("\n", "\r\n"), keys) == line


@pytest.mark.parametrize("board", boards.BOARD_NAMES)
def test_a_new_file_is_valid_with_all_its_comments_taken_in(put, board):
    kinds = dict(zip(("M39", "M40"), ("smooth", "plain"), strict=True))
    motors = dict(list(kinds.items())[: boards.load(board).axes])
    text = files.new_text(board, Fraction(30000, 1001), motors)
    assert files.problems(put(text.encode())) == []
    lines = []
    for line in text.splitlines():
        bare = line.removeprefix("# ")
        lines.append(bare if line != bare and " = " in bare else line)
    full = put("\n".join(lines).encode())
    assert files.problems(full) == []
    motor = MachineFile.load(full)["M39"]
    assert motor.profiles.line and motor.limits.max_jerk and motor.limits.start_stop
    assert len(lines) == len(text.splitlines()) and max(map(len, lines)) <= 100


def test_new_check_and_show(pixstep, invoke, tmp_path):
    words = ("machine", "new", "--board", "mega", "--pixel-hz", "30")
    assert "machine.toml" in pixstep(*words, "--motor", "M39:smooth", "--motor", "M40:plain")
    assert "already exists" in invoke(*words, status=2).stderr
    assert pixstep("machine", "check") == "machine.toml: fine\n"
    shown = json.loads(pixstep("machine", "show", "--json"))
    assert shown["schema"] == 1 and shown["machine"] == "machine.toml"
    assert shown["motors"]["M39"]["limits"]["max_speed"] == {
        "steps/px": 400, "steps/s": 12000, "mm/s": 30,
    }  # fmt: skip
    page = pixstep("machine", "show")
    assert "machine.toml: 30 Hz, lines for M39" in page and "400/mm" in page
    assert all(len(line) <= 80 for line in page.splitlines())
    assert "one of" not in pixstep(*words, "--force")
    assert invoke("machine", "new", *words[2:], "-o", "b.toml", "--motor", "M3", status=2)
    assert not (tmp_path / "b.toml").exists()


def test_check_lists_all_mistakes_and_warnings(pixstep, put):
    put(GOOD.replace("axis = 0", "axis = 9").replace('"plain"', '"x"').encode(), "machine.toml")
    assert len(pixstep("machine", "check", status=3).splitlines()) == 2
    slow = GOOD.replace("128 steps/px2", "1 steps/px2").replace("30 mm/s", "999 mm/s")
    put(slow.encode(), "machine.toml")
    output = pixstep("machine", "check", status=1)
    assert "max_speed = '999 mm/s': the mega makes 2006 steps/px = 60119.9 steps/s" in output
    assert "max_acceleration = '1 steps/px2': a smooth line has 1796.41 steps/s2 at" in output
    assert json.loads(pixstep("machine", "check", "--json", status=1))["verdict"] == "warnings"
    put(GOOD.replace("30000/1001", "20000").encode(), "machine.toml")
    assert "clock.pixel: mega: pixel frequency 20000 Hz" in pixstep("machine", "check", status=1)


def test_a_profile_that_is_not_made_yet_is_a_note(invoke, put):
    put(GOOD.encode(), "machine.toml")
    made = invoke("machine", "check")
    assert made.stdout == "machine.toml: fine\n"
    assert made.stderr == (
        "note: machine.toml: motors.M39.profiles.line: AccProfM39-30Hz-1.PRN: there is no such "
        "file yet (`pixstep profile make` makes one)\n"
    )
    facts = json.loads(invoke("machine", "check", "--json").stdout)
    assert facts["verdict"] == "fine" and not facts["warnings"] and len(facts["notes"]) == 1
    put(b"", "AccProfM39-30Hz-1.PRN")
    assert not invoke("machine", "check").stderr


def test_no_file_at_all(invoke):
    assert "`pixstep machine new` begins one" in invoke("machine", "show", status=2).stderr
