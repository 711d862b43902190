# SPDX-License-Identifier: MIT
"""The program that makes tables for the Python package out of the firmware's .def files."""

import json
import subprocess
import sys

import pytest

import deffiles
import register_rows
import tables
from deffiles import TableError
from pixstep import natives
from pixstep.board import boards

TABLE = """\
// SPDX-License-Identifier: MIT
/* a block
   INPUT(9, hidden, u16, "", "no") */
INPUT(0, map_version, u16, "", "version of this map") // trailing
INPUT(0x0C, pixel_edges, u32, "px", "edges, so \\"far\\" "
      "(all of them)")
INPUT_AXIS(6, position_steps, i32, "steps", "pulses made")
#define NOTHING 1
HOLDING(9, backlash_policy, u16, "", 0, 1, 0, "0 always, 1 on reversal")
"""


@pytest.fixture
def table(tmp_path):
    path = tmp_path / "registers.def"

    def write(text):
        path.write_text(text)
        return path

    return write


def test_parse(table):
    parsed = register_rows.registers(table(TABLE))
    version, edges = parsed["inputs"]
    assert version["name"] == "map_version"
    assert (edges["name"], edges["address"], edges["unit"]) == ("pixel_edges", 12, "px")
    assert edges["meaning"] == 'edges, so "far" (all of them)'
    (policy,) = parsed["holdings"]
    assert (policy["minimum"], policy["maximum"], policy["default"]) == (0, 1, 0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('INPUT(0, a, u16, "", "x")\nINPUT(0, b, u16, "", "y")', "b overlaps a at 0"),
        ('INPUT(0, a, u32, "", "x")\nINPUT(1, b, u16, "", "y")', "b overlaps a at 1"),
        ('INPUT(0, a, u8, "", "x")', ":1: unknown type u8"),
        ('INPUT(0, a, u16, "")', ":1: INPUT takes 5 arguments"),
        ('OUTPUT(0, a, u16, "", "x")', ":1: unknown row OUTPUT"),
        ("INPUT(0, a", ":1: .* does not end"),
        ("nonsense", "is not a row"),
    ],
)
def test_bad_tables(table, text, message):
    with pytest.raises(TableError, match=message):
        register_rows.registers(table(text))


NAMES = ("code", "name")


def test_duplicate_code(table):
    with pytest.raises(TableError, match="code 1 is used twice"):
        register_rows.codes(table("E(1, a)\nE(1, b)"), "E", NAMES)


def test_codes_name_the_arguments_they_lack(table):
    with pytest.raises(TableError, match=r":2: expected E\(code, name\)"):
        register_rows.codes(table("E(1, a)\nE(2)"), "E", NAMES)


def test_rows_know_where_they_stand(table):
    path = table(TABLE)
    assert [row.where for row in deffiles.read_rows(path)][1] == f"{path}:5"


def meanings(unit, meaning, axes=2):
    group = {"inputs": [{"name": "x", "unit": unit, "meaning": meaning}]}
    register_rows.add_meanings(group, {}, axes)
    return group["inputs"][0].get("values")


def test_meanings_of_values_and_bits():
    assert meanings("state", "0 empty, 1 loading") == {"0": "empty", "1": "loading"}
    text = "it: 0 on; and more, 8 to 9 axis n stops"
    assert meanings("bits", text) == {"0": "on", "8": "axis 0 stops", "9": "axis 1 stops"}
    text = "four bits an axis: 0 home, 2 limit"
    assert meanings("bits", text) == {
        "0": "axis 0 home", "2": "axis 0 limit", "4": "axis 1 home", "6": "axis 1 limit",
    }  # fmt: skip
    assert meanings("ticks", "0 nothing, 1 something") is None


def test_codes_are_the_meanings_of_the_registers_that_hold_them():
    group = {"inputs": [{"name": "word", "unit": "bits", "meaning": "0 no, 1 such"}]}
    register_rows.add_meanings(group, {"word": [{"bit": 3, "name": "store"}]}, 1)
    assert group["inputs"][0]["values"] == {"3": "store"}


def test_the_package_has_what_the_sources_say():
    made = tables.tables(natives.root() / "firmware")
    assert json.loads(natives.made("tables.json").read_text()) == json.loads(json.dumps(made))


@pytest.fixture
def firmware(tmp_path):
    """Return a folder with the tables of the firmware, to be changed."""
    folder = tmp_path / "firmware"
    for path in (natives.root() / "firmware").rglob("*.def"):
        place = folder / path.relative_to(natives.root() / "firmware")
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(path.read_text())
    return folder


def fourth(firmware, **changes):
    """Write a board like the Mega with another name and number, and constants changed."""
    folder = firmware / "avr" / "boards"
    text = (folder / "mega.def").read_text()
    for name, value in {"NAME": '"nano"', "ID": 9, **changes}.items():
        old = next(row for row in text.split("\n") if row.startswith(f"#define BOARD_{name} "))
        text = text.replace(old, f"#define BOARD_{name} {value}" if value is not None else "")
    (folder / "nano.def").write_text(text)


def test_a_file_more_is_a_board_more(firmware):
    fourth(firmware)
    made = tables.tables(firmware)["boards"]
    assert [row["name"] for row in made] == [*boards.BOARD_NAMES, "nano"]
    assert made[-1]["timers"] == {str(axis): t for axis, t in boards.load("mega").timers.items()}


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"CPU_HZ": None}, "BOARD_CPU_HZ is missing"),
        ({"CPU_HZ": "fast"}, "BOARD_CPU_HZ is not a number"),
        ({"AXES": 3}, "BOARD_AXES is 3, 4 rows BOARD_AXIS"),
    ],
)
def test_a_wrong_file_is_named_in_one_line(firmware, changes, text):
    fourth(firmware, **changes)
    program = natives.root() / "tools" / "generate" / "tables.py"
    output = firmware / "tables.json"
    done = subprocess.run(
        [sys.executable, program, firmware, output], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1 and not output.exists()
    assert done.stderr.strip() == f"{firmware / 'avr' / 'boards' / 'nano.def'}: {text}"
