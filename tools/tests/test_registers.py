# SPDX-License-Identifier: MIT
"""The register map, the codes and the board tables, as the build generates them."""

import pytest

from pixstep.board import boards, registers
from pixstep.errors import UserError


def test_an_unknown_register_is_refused():
    with pytest.raises(UserError, match="no register 'nothing'"):
        registers.register_map().input("nothing")


def test_signed_values_of_two_registers():
    assert registers.register_map().axis_input("position_steps").decode([0xFFFF, 0xFFFE]) == -2


def test_codes_of_the_firmware():
    assert registers.faults()[1].name == "starved"
    assert registers.line_errors()[4].name == "oscillates"
    assert registers.code_name(registers.faults(), 99) == "code 99"


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
