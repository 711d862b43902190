# SPDX-License-Identifier: MIT
"""Wiring drawings and the tables of other people's parts: the boards' pins, nothing ambiguous."""

import re
import tomllib
from itertools import combinations
from xml.etree import ElementTree

import pytest
from click.testing import CliRunner

from pixstep import natives
from pixstep.board import boards
from pixstep_dev.cli.main import main
from pixstep_dev.docs import parts, wiring

SVG = "{http://www.w3.org/2000/svg}"
DRAWINGS = wiring.drawings()
_PIN = r"(?:P[A-D]|[AD])\d+"
SIGNALS = ("HOME", "LIMIT_MINUS", "LIMIT_PLUS", "ESTOP", "PERMIT", "PIXEL_CLOCK")


def words(text):
    return [node.text for node in ElementTree.fromstring(text).iter(f"{SVG}text")]


def wires(text):
    """Return each wire as the list of its straight pieces (x0, y0, x1, y1)."""
    for path in ElementTree.fromstring(text).iter(f"{SVG}path"):
        if path.get("stroke-width") == "2" and "m" not in path.get("d"):
            pieces = []
            for x, y, way, to in re.findall(r"M([\d.]+) ([\d.]+)([HV])([\d.]+)", path.get("d")):
                x, y, to = float(x), float(y), float(to)
                end = (to, y) if way == "H" else (x, to)
                pieces.append((min(x, end[0]), min(y, end[1]), max(x, end[0]), max(y, end[1])))
            yield pieces


def share_a_line(one, other):
    """True if two straight pieces lie upon each other for more than a point."""
    across = one[1] == one[3] == other[1] == other[3]
    upright = one[0] == one[2] == other[0] == other[2]
    if across:
        return min(one[2], other[2]) > max(one[0], other[0])
    return upright and min(one[3], other[3]) > max(one[1], other[1])


@pytest.mark.parametrize("name", sorted(DRAWINGS))
def test_no_two_wires_share_a_line(name):
    found = list(wires(DRAWINGS[name]))
    assert len(found) > 1
    for first, second in combinations(found, 2):
        assert not any(share_a_line(one, other) for one in first for other in second)


def labels(text):
    """Return each text as (words, x0, y0, x1, y1), as wide as it may be drawn."""
    for node in ElementTree.fromstring(text).iter(f"{SVG}text"):
        x, y = float(node.get("x")), float(node.get("y"))
        width = len(node.text) * (8.5 if node.get("class") == "title" else 7)
        share = {"end": 1, "middle": 0.5}.get(node.get("text-anchor"), 0)
        yield node.text, x - share * width, y - 9, x + (1 - share) * width, y + 1


def crosses(one, other):
    """True if two rectangles have a point in common."""
    return one[0] <= other[2] and other[0] <= one[2] and one[1] <= other[3] and other[1] <= one[3]


@pytest.mark.parametrize("name", sorted(DRAWINGS))
def test_no_label_is_crossed_or_leaves_the_drawing(name):
    found = list(labels(DRAWINGS[name]))
    _, _, wide, high = map(float, ElementTree.fromstring(DRAWINGS[name]).get("viewBox").split())
    pieces = [piece for wire in wires(DRAWINGS[name]) for piece in wire]
    for words_, *box in found:
        assert box[0] >= 0 and box[2] <= wide and box[3] <= high, words_
        assert not any(crosses(box, piece) for piece in pieces), words_
    for (first, *one), (second, *other) in combinations(found, 2):
        assert not crosses(one, other), f"{first} and {second}"


@pytest.mark.parametrize("board", wiring.BOARDS)
def test_each_pin_is_the_boards_own(board):
    for driver in ("a4988", "drv8825", "tmc2209", "opto"):
        said = words(DRAWINGS[f"{board}-{driver}.svg"])
        for signal in ("STEP", "DIR", "ENABLE"):
            assert_pins(board, signal, said)
    said = words(DRAWINGS[f"{board}-inputs.svg"])
    for signal in SIGNALS:
        assert_pins(board, signal, said)


def assert_pins(board, signal, said):
    (row,) = [text for text in said if re.match(rf"{signal} {_PIN}", text)]
    pins = [pin.header for pin in boards.load(board).pins if pin.signal == signal]
    assert re.findall(_PIN, row.partition(" ")[2]) == pins


def test_the_bare_chip_has_every_signal_on_its_leg():
    """The legs of the DIP-40, as the data sheet has them."""
    said = words(DRAWINGS["m1284-chip.svg"])
    legs = {"PA0": 40, "PA5": 35, "PB2": 3, "PB5": 6, "PB7": 8, "PC0": 22, "PC7": 29, "PD4": 18}
    shown = dict(re.findall(r"(P[A-D]\d) (\d+)$", "\n".join(said), re.MULTILINE))
    assert {pin: int(shown[pin]) for pin in legs} == legs
    for pin in boards.load("m1284").pins:
        assert any(text.startswith(pin.signal) and f" {pin.header} " in text for text in said)


def test_the_wire_of_a_clock_joins_output_and_inputs():
    said = words(DRAWINGS["clock-own.svg"])
    for name in wiring.BOARDS:
        for pin in boards.load(name).pins:
            if pin.signal.startswith(("CLOCK_OUT", "PIXEL_CLOCK")):
                assert f"{pin.signal} {pin.header}" in said
    assert len(list(wires(DRAWINGS["clock-own.svg"]))) == len(wiring.BOARDS)


def test_what_differs_is_named_and_rewritten(tmp_path):
    run = CliRunner().invoke
    words_of = ["docs", "drawings", str(tmp_path)]
    assert run(main, words_of).exit_code == 1
    assert run(main, [*words_of, "--write"]).exit_code == 0
    (tmp_path / "rs485.svg").write_text("another")
    (tmp_path / "forgotten.svg").write_text("")
    done = run(main, words_of)
    assert done.exit_code == 1
    assert "rs485.svg" in done.stderr and "forgotten.svg" in done.stderr
    assert run(main, [*words_of, "--write"]).exit_code == 0
    assert run(main, words_of).exit_code == 0
    assert not (tmp_path / "forgotten.svg").exists()


def test_pulses_are_those_of_the_firmware():
    """STEP is low for 2 us; a driver that asks for more is not called fit."""
    assert parts.low_us() == 2
    assert parts.high_us("uno") == pytest.approx(63 / 16 - 2)
    widths = parts.drivers().partition("\n\n")[0]
    rows = {row.split(" | ")[0].strip("| "): row for row in widths.splitlines()}
    assert "fits at every rate" in rows["A4988"]
    assert "too short" in rows["opto-isolated, DM542 and alike"]


def test_every_shield_says_what_is_at_each_pin():
    text = (natives.root() / "tools/dev/pixstep_dev/data/wiring.toml").read_text()
    for shield in tomllib.loads(text)["shield"]:
        for pin in boards.load(shield["board"]).pins:
            assert shield["pins"][pin.header]
        for socket, pin in shield["sockets"].items():
            assert shield["pins"][pin].startswith(f"{socket} socket, STEP")
