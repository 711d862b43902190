# SPDX-License-Identifier: MIT
"""The .def reader, the register map and the board tables."""

import pytest

from pixstep.board import boards, deffiles, registers
from pixstep.errors import UserError

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
    parsed = registers.parse_registers(table(TABLE))
    assert [r.name for r in parsed.inputs] == ["map_version", "pixel_edges"]
    edges = parsed.input("pixel_edges")
    assert (edges.address, edges.words, edges.unit) == (12, 2, "px")
    assert edges.meaning == 'edges, so "far" (all of them)'
    assert parsed.axis_input("position_steps").decode([0xFFFF, 0xFFFE]) == -2
    policy = parsed.holding("backlash_policy")
    assert (policy.minimum, policy.maximum, policy.default) == (0, 1, 0)
    with pytest.raises(UserError, match="no register 'nothing'"):
        parsed.input("nothing")


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
    with pytest.raises(UserError, match=message):
        registers.parse_registers(table(text))


def test_codes_of_the_firmware():
    assert registers.faults()[1].name == "starved"
    assert registers.line_errors()[4].name == "oscillates"
    assert registers.code_name(registers.faults(), 99) == "code 99"


def test_duplicate_code(table):
    with pytest.raises(UserError, match="code 1 is used twice"):
        registers.parse_codes(table('E(1, a, "x", "y")\nE(1, b, "x", "y")'), "E", registers.Code)


def test_codes_name_the_arguments_they_lack(table):
    with pytest.raises(UserError, match=r":2: expected E\(code, name, text, cure\)"):
        registers.parse_codes(table('E(1, a, "x", "y")\nE(2, b, "x")'), "E", registers.Code)


@pytest.mark.parametrize("codes", [registers.faults(), registers.line_errors()])
def test_every_code_says_what_to_do(codes):
    for code in codes.values():
        sentences = [code.cure, *([code.cause] if isinstance(code, registers.Fault) else [])]
        for sentence in sentences if code.code else ():
            assert sentence[0].isupper() and sentence.endswith("."), code.name
        assert code.text and not code.text.endswith(".")


@pytest.mark.parametrize(("name", "axes"), [("uno", 1), ("mega", 4), ("m1284", 2)])
def test_boards(name, axes):
    board = boards.load(name)
    assert board.axes == axes
    pins = [(pin.port, pin.bit) for pin in board.pins]
    assert len(pins) == len(set(pins)), "a pin has two signals"
    for signal in ("STEP", "DIR", "ENABLE"):
        assert sorted(pin.axis for pin in board.pins if pin.signal == signal) == list(range(axes))


def test_unknown_board():
    with pytest.raises(UserError, match="unknown board 'due'"):
        boards.load("due")


def test_rows_know_where_they_stand(table):
    path = table(TABLE)
    assert [row.where for row in deffiles.read_rows(path)][1] == f"{path}:5"
