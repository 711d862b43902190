# SPDX-License-Identifier: MIT
"""Operations with lines, profiles and files give Python what they give the command line."""

import json
import pickle

import pytest

from pixstep import formats, natives, ops
from pixstep.errors import AskedText, RefusedError, UserError
from pixstep.operations.asked import AskedError, FieldError

PRN = natives.example("AccProfM39-30Hz-1.PRN")
LIMITS = {"max_acceleration": 10, "start_stop": 4}
# What Python calls, and what the same is on the command line.
SAME = [
    ("line_check", ["s.csv"], {"decode": "smooth", "pixel_hz": 30, "board": "mega"}),
    ("line_check", ["s.csv"], {"decode": "smooth", "jerk_warn": 1}),
    ("line_check", ["s.csv"], {"decode": "smooth", "backlash": 250}),
    ("ticks", ["s.csv"], {"decode": "smooth", "pixel_hz": 30, "output": "plan.csv"}),
    ("line_show", ["s.csv"], {"decode": "smooth", "pixel_hz": 30}),
    ("line_import", ["own.txt"], {"decode": "plain", "output": "made.csv"}),
    ("line_compensate", ["t.csv"], {"play": 4, **LIMITS, "output": "made.csv"}),
    ("profile_make", [], {"top_speed": 1000, "max_acceleration": 128, "max_jerk": 40,
                          "output": "made.PRN"}),
    ("profile_check", [PRN], {"max_jerk": 2}),
    ("profile_show", [PRN], {"speed": 100}),
    ("profile_repair", ["odd.csv"], {"output": "made.csv"}),
    ("file_info", ["s.csv"], {}),
    ("file_check", ["s.csv"], {}),
    ("file_convert", ["s.csv", "s.csb"], {}),
    ("limits", [], {"board": "mega", "pixel_hz": 200, "max_speed": 100}),
]  # fmt: skip


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Put files into the current folder."""
    monkeypatch.chdir(tmp_path)
    for name, counts in {
        "s.csv": [2, 6, 8, 10, 12, 12, 12, 10, 8, 6, 2],
        "t.csv": [3, 3, 3, 3, -3, -3, -3, -3, -3],
        "odd.csv": [5, 10, 20, 20, 20, 20, 20, 20, 20, 20, 10, 5],
    }.items():
        formats.write_csv(tmp_path / name, counts)
    (tmp_path / "own.txt").write_text("1\n3\n4\n3\n1\n")
    (tmp_path / "odd.txt").write_text("6\n6\n6\n6\n")
    return tmp_path


@pytest.mark.parametrize(("name", "places", "given"), SAME)
def test_python_and_the_command_line_give_the_same(here, invoke, name, places, given):
    made = getattr(ops, name)(*places, **given)
    words = [*name.split("_"), *map(str, places), "--json", "--machine", "none"]
    words = words[:-2] if name.startswith("file") else words
    for key, value in given.items():
        words += [f"--{key.replace('_', '-')}", str(value)]
    done = invoke(*words, *(["--force"] if {"output"} & set(given) or len(places) > 1 else []),
                  status=made.status)  # fmt: skip
    printed = json.loads(done.stdout)
    for key in ("schema", "machine"):
        printed.pop(key, None)
    assert json.loads(json.dumps(made.to_dict())) == printed
    assert made.page()


@pytest.mark.parametrize(
    ("call", "kind", "said"),
    [
        (lambda: ops.line_show("s.csv", decode="smooth", pixel_hz=30, max_speed="10steps/s"),
         AskedError, "max_speed: 10steps/s is 0.3333333 steps/px: at least 1 steps/px: clock_hz 30 "
         "divider 3 "
         "would do"),
        (lambda: ops.line_compensate("t.csv", play=4, start_stop=4, output="c.csv", pixel_hz=30,
                                     max_acceleration="9steps/s2"),
         AskedError, "max_acceleration: 9steps/s2 is 0.01 steps/px2: at least 1 steps/px2: pixels "
         "of 10 clock edges would do, pixel_hz 3"),
        (lambda: ops.line_check("s.csv", decode="smooth", pixel_hz=30, axes=9),
         AskedError, "axes 9: uno has 1 axis: 0"),
        (lambda: ops.profile_show("s.csv", speed=100),
         AskedError, "s.csv: speed is for a PRN, a CSV holds counts"),
        (lambda: ops.profile_make(top_speed=1000, max_acceleration=128, max_jerk=40, haps=3,
                                  output="p.PRN"),
         AskedError, "haps is for the CSV profile: give csv"),
        (lambda: ops.profile_make(top_speed=1000, max_acceleration=128, max_jerk=40, pixel_hz=30,
                                  output="p.csv", csv="p.csv"),
         AskedError, "p.csv: output and csv are the same file"),
        (lambda: ops.profile_make(top_speed=1000, max_acceleration=128, max_jerk=40, pixel_hz=30,
                                  motor="M39", variant="7", csv="AccProfM39-30Hz-7.PRN"),
         AskedError, "AccProfM39-30Hz-7.PRN: output and csv are the same file"),
        (lambda: ops.profile_make(top_speed=1000, max_acceleration=128, max_jerk=40),
         AskedError, "the conventional name needs motor, variant, pixel_hz; or give a file name: "
         "output"),
        (lambda: ops.profile_repair(PRN, part="line", output="p.PRN"),
         AskedError, f"{PRN}: part is for counts; `profile make` keeps limits of a PRN"),
        (lambda: ops.line_compensate("t.csv", play=4, **LIMITS, output="c.csv", transition_px=0),
         FieldError, "transition_px: 0: a number of pixels from 1, or auto"),
        (lambda: ops.line_import("own.txt", decode="plain", output="c.csv", column=3),
         UserError, "own.txt: there is no column '3': 1 to 1"),
        (lambda: ops.line_import("own.txt", decode="plain", output="c.csv", column=0),
         FieldError, "column: 0 is not in the range x>=1"),
        (lambda: ops.ticks("odd.csv", decode="smooth", pixel_hz=30, output="c.csv"),
         RefusedError, "odd.csv: line refused: oscillates at pixel 3"),
    ],
)  # fmt: skip
def test_what_is_wrong_names_fields(here, call, kind, said):
    before = sorted(here.iterdir())
    with pytest.raises(kind) as raised:
        call()
    assert str(raised.value).startswith(said)
    assert sorted(here.iterdir()) == before


def test_what_would_do_is_said_of_a_machine_file_of_any_name(here):
    machine = here / "{speed}.toml"
    machine.write_text(
        'clock.pixel = 30\nboards.main.kind = "mega"\n'
        'motors.X = { axis = 0, kind = "plain", limits.max_speed = "3 steps/s" }\n'
    )
    with pytest.raises(AskedError) as raised:
        ops.line_check("t.csv", machine=machine)
    assert str(raised.value) == (
        "3 steps/s is 0.1 steps/px: at least 1 steps/px: divider 10 would do, or divider = 10 in "
        f"the table [clock] of {machine}"
    )


def test_a_motor_is_not_an_axis_by_how_many_move(here):
    """`axes` is a number of axes here, and none of them."""
    machine = here / "machine.toml"
    machine.write_text(
        'clock.pixel = 30\nline.motor = "X"\nboards.main.kind = "mega"\n'
        'motors.X = { axis = 3, kind = "smooth" }\nmotors.Y = { axis = 1, kind = "plain" }\n'
    )
    assert ops.line_check("s.csv", axes=2, machine=machine)["decode"] == "smooth"


def test_notes_come_with_the_result(here):
    made = ops.line_import("own.txt", decode="plain", output="made.csv", column=1)
    assert "column 1 is the steps of each pixel" in made.notes
    assert ops.line_check("s.csv", decode="smooth", pixel_hz=30).notes == (
        "s.csv: checked by what the Arduino Uno can do (board)",
    )
    text = (here / "s.csv").read_bytes().replace(b"\r\n", b"\n")
    (here / "s.csv").write_bytes(text)
    with pytest.raises(RefusedError, match=r"ends with LF.* \(lenient accepts it\)$"):
        ops.line_check("s.csv", decode="smooth")
    with pytest.raises(
        RefusedError, match=r"^odd.txt: pixel 1: .* \(fit makes the nearest line\)$"
    ):
        ops.line_import("odd.txt", decode="smooth", output="made.csv", force=True)
    (note,) = ops.line_check("s.csv", decode="smooth", lenient=True).notes
    assert "LF instead of CR LF" in note


def test_a_page_is_what_the_command_prints(here, invoke):
    made = ops.file_check("odd.csv")
    assert made.page() + "\n" == invoke("file", "check", "odd.csv").stdout
    made = ops.file_info("odd.csv")
    assert made.page() + "\n" == invoke("file", "info", "odd.csv").stdout


# An error of the layers below, as each front end words it: Python's call, its text, the command's.
WORDED = [
    ("line_check", ["s.csv"], {"decode": "smooth", "max_speed": "3steps/s"},
     "speed 3steps/s: per second needs {}", ["pixel_hz"], ["--pixel-hz"]),
    ("file_convert", ["s.csv", "s.prn"], {},
     "s.csv: a PRN holds speeds for a smooth motor and counts for a plain one, a CSV or CSB counts "
     "for both: {} plain says", ["decode"], ["--decode"]),
    ("line_import", ["two.txt"], {"decode": "plain", "output": "made.csv"},
     "two.txt:2: 2 columns (a, b): choose one by {}", ["column"], ["--column"]),
    ("line_import", ["half.txt"], {"decode": "plain", "output": "made.csv"},
     "half.txt:1: column 1: say what it holds: {} position|speed|steps and {} steps|",
     ["quantity", "length_unit"], ["--quantity", "--unit"]),
    ("sim", ["s.csv"], {"decode": "smooth", "pixel_hz": 30, "board": "mega", "backlash": 250,
                        "out": "run"},
     "{{s.csv}}: line refused: backlash_over_speed at pixel 1: the backlash does not fit one pixel "
     "at line speed (B > V): backlash 250, speed 12 (`pixstep line check` shows all; {} lets",
     ["check=False"], ["--no-check"]),
]  # fmt: skip


@pytest.mark.parametrize(("name", "places", "given", "text", "python", "options"), WORDED)
def test_each_front_end_has_its_own_words(here, invoke, name, places, given, text, python, options):
    (here / "two.txt").write_text("a,b\n1,5\n3,2\n")
    (here / "half.txt").write_text("0.5\n1\n")
    text = text.replace("{{", "").replace("}}", "")
    with pytest.raises(UserError) as caught:
        getattr(ops, name)(*places, **given)
    assert str(caught.value).startswith(text.format(*python))
    again = pickle.loads(pickle.dumps(caught.value))
    assert type(again) is type(caught.value) and str(again) == str(caught.value)
    words = [*name.split("_"), *places, "--machine", "none"]
    words = words[:-2] if name.startswith("file") else words
    for key, value in given.items():
        words += [f"--{key.replace('_', '-')}", str(value)]
    done = invoke(*words, status=caught.value.status)
    assert done.stderr.startswith("pixstep: " + text.format(*options))


def test_a_text_keeps_what_it_is_made_of():
    inner = AskedText("{path}: needs {pixel_hz}", path="a{b}.csv")
    text = AskedText("{line}: {error}", error=UserError(inner))
    for one in (text, pickle.loads(pickle.dumps(text))):
        assert one == "line: a{b}.csv: needs pixel_hz"
        assert one.told({"pixel_hz": "--pixel-hz"}) == "line: a{b}.csv: needs --pixel-hz"
