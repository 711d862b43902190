# SPDX-License-Identifier: MIT
"""Generated tables: complete, replaced between markers, drift found; constants without drift."""

import re

import pytest
from click.testing import CliRunner

from effort import cases
from pixstep import natives
from pixstep.board import registers
from pixstep.errors import UserError
from pixstep_dev import markdown
from pixstep_dev.cli.main import main
from pixstep_dev.docs import tables


def test_protocol_table_names_everything():
    text = tables.protocol()
    parsed = registers.register_map()
    for register in (*parsed.inputs, *parsed.axis_inputs, *parsed.holdings):
        assert f"`{register.name}`" in text
    for codes in (registers.faults(), registers.line_errors()):
        assert all(f"`{code.name}`" in text for code in codes.values())


def test_wiring_table():
    text = tables.wiring()
    assert "| STEP | 0 | D12 | PB6 | OC1B |" in text
    assert "| PIXEL_CLOCK |  | D8 | PB0 |  |" in text


# The API's text takes a second each time; `rules.api` generates and compares it in the quick check.
QUICK_NAMES = ["protocol", "wiring", "drivers", "shields", "files", "grammar"]


@pytest.mark.parametrize("name", cases(QUICK_NAMES, [*QUICK_NAMES, "api"]))
def test_write_then_check(tmp_path, name):
    path = tmp_path / "DOC.md"
    path.write_text("before\n" + markdown.marked(name, "stale content") + "after\n")

    def run(option):
        return CliRunner().invoke(main, ["docs", name, option, str(path)]).exit_code

    assert run("--check") == 1
    assert run("--write") == 0
    assert run("--check") == 0
    text = path.read_text()
    assert text.startswith("before\n") and text.endswith("after\n") and "stale content" not in text


def test_missing_markers():
    with pytest.raises(UserError, match="has no markers"):
        markdown.between("text", "protocol", "x")


@pytest.mark.parametrize(
    ("define", "value"),
    [
        ("REG_AXIS_BASE", registers.AXIS_BASE),
        ("REG_AXIS_STRIDE", registers.AXIS_STRIDE),
        ("REG_RECORD_BASE", registers.RECORD_BASE),
        ("REG_RECORD_STRIDE", registers.RECORD_STRIDE),
        ("REG_RECORD_HEADER", registers.RECORD_HEAD),
        ("REG_RECORD_WORDS", registers.RECORD_REGISTERS),
        ("REG_QUEUE_WINDOW", registers.QUEUE_WINDOW),
    ],
)
def test_array_areas_are_where_the_firmware_has_them(define, value):
    text = natives.source("firmware/core/wire/register_map.h").read_text()
    (found,) = re.findall(rf"#define {define}\s+(\w+?)u?\b", text)
    assert int(found.rstrip("u"), 0) == value


def test_command_block():
    holding = registers.register_map().holding
    assert holding("axis_mask").address == registers.COMMAND_BASE
    meaning = holding("command").meaning
    for name, code in registers.COMMANDS.items():
        assert f"{code} {name.split('_')[0]}" in meaning
