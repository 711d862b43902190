# SPDX-License-Identifier: MIT
"""Mutated frames while lines run; `pixstep-dev robustness frames` is the long form."""

import random
import struct
from collections import Counter

import pytest

from clock import TICK_HZ
from effort import cases
from pixstep.lines.line_check import check, refused
from pixstep_dev.robustness import framestorm, strikes
from pixstep_trials import wire

# What is tried is the serial server, the same code on every board: a third one only takes time.
TWO = ("uno", "mega")
SAFETY = wire.Safety(4, lambda axis: 7)
PAUSES = strikes.Pauses.at(TICK_HZ)
FRAMES = cases(600, 1500)


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", TWO)
def test_no_edge_differs(board):
    outcome = framestorm.run(framestorm.FramestormPlan(board, FRAMES))
    assert outcome.complaints == []
    assert outcome.frames >= FRAMES
    assert len(outcome.kinds) == 15
    assert min(outcome.kinds.values()) > FRAMES // 20
    assert outcome.edges > 30 * FRAMES
    assert outcome.counters["crc_errors"] > FRAMES // 8
    assert outcome.counters["exceptions"] > FRAMES // 8


@pytest.mark.usefixtures("simulator")
def test_a_frame_that_is_obeyed_is_found(monkeypatch):
    """With a generator that lets a stop through, the storm says that edges are missing."""
    monkeypatch.setattr(wire.Safety, "harmless", lambda self, frame: True)
    stop = wire.seal(b"\x01\x10" + struct.pack(">HHBHH", 0x0100, 2, 4, 1, 3))
    original = strikes.Generator._any_function

    def any_function(self):
        original(self)
        return strikes.Strike(
            "any function", ((b"", self.pauses.certain), (stop, self.pauses.answer))
        )

    monkeypatch.setattr(strikes.Generator, "_any_function", any_function)
    outcome = framestorm.run(framestorm.FramestormPlan("uno", 300))
    assert any("edges differ" in text for text in outcome.complaints)
    assert any("axis 0: " in text for text in outcome.complaints)


QUIET = (
    "cycle,board,axis,signal,level\n10,0,0,ENABLE,0\n20,0,0,DIR,1\n30,0,0,STEP,1\n40,0,0,STEP,0\n"
)


@pytest.mark.parametrize(
    ("storm", "complaint"),
    [
        (QUIET, ""),
        (QUIET + "50,0,0,ENABLE,1\n", ""),  # behind the last step: a setting counts again
        (QUIET.replace("20,", "25,"), ""),
        (QUIET.replace("40,0,0", "35,0,0,PERMIT,1\n40,0,0"), "other edges of direction, enable"),
        (QUIET.replace("20,0,0,DIR,1\n", ""), "other edges of direction, enable"),
        (QUIET.replace("40,", "41,"), "edges differ from '40,0,0,STEP,0'"),
    ],
)
def test_what_differs_is_said(tmp_path, storm, complaint):
    for name, text in (("quiet", QUIET), ("storm", storm)):
        (tmp_path / name).write_text(text)
    outcome = framestorm.FramestormOutcome(framestorm.FramestormPlan("uno", 1))
    framestorm._compare(tmp_path / "quiet", tmp_path / "storm", outcome)
    assert len(outcome.complaints) == bool(complaint)
    assert not complaint or outcome.complaints[0].startswith(complaint)
    assert outcome.turns == 1 and outcome.edges == 2
    assert outcome.turn_shift_cycles == (5 if "25,0,0,DIR" in storm else 0)


@pytest.mark.parametrize("axis", range(4))
def test_lines_are_fine(axis):
    line = framestorm.line(axis, 8)
    assert not refused(check(line))
    assert line.pixels == 8 * framestorm.PART_PX


def words(*values):
    return struct.pack(f">{len(values)}H", *values)


@pytest.mark.parametrize(
    ("body", "harmless"),
    [
        (b"\x04" + words(0, 2), True),
        (b"\x06" + words(0x0006, 5), True),  # a setting: refused while lines are queued
        (b"\x06" + words(0x0101, 3), False),
        (b"\x06" + words(0x0101, 14), True),  # mark: nothing moves
        (b"\x06" + words(0x0101, 15), True),  # no such command
        (b"\x10" + words(0x0100, 2) + b"\x04" + words(1, 3), False),
        (b"\x10" + words(0x0100, 2) + b"\x03" + words(1, 3), True),  # wrong byte count
        (b"\x10" + words(0x0100, 4) + b"\x08" + words(1, 3, 0, 0), False),
        (b"\x10" + words(0x0100, 5) + b"\x0a" + words(1, 3, 0, 0, 0), True),  # not mapped
        (b"\x10" + words(0x1000, 4) + b"\x08" + words(7, 0, 5, 1), False),  # the block that is due
        (b"\x10" + words(0x1000, 4) + b"\x08" + words(9, 0, 5, 1), True),
        (b"\x10" + words(0x1000, 4) + b"\x08" + words(7, 4, 5, 1), True),  # no such axis
        (b"\x05" + words(8, 0xFF00), False),
        (b"\x05" + words(0x40, 0xFF00), True),
        (b"\x0f" + words(0, 4) + b"\x01\x0f", False),
        (b"\x16" + words(0x0101, 0, 3), False),
        (b"\x17" + words(0, 1, 0x0100, 2) + b"\x04" + words(1, 3), False),
        (b"\x17" + words(0, 1, 0x0000, 1) + b"\x02" + words(9), True),
        (b"\x08" + words(0, 0x1234), True),
        (b"\x08" + words(4, 0), False),  # listen-only
        (b"\x63", True),
    ],
)
def test_what_is_harmless(body, harmless):
    assert SAFETY.harmless(wire.seal(b"\x01" + body)) is harmless


def stretches(strike):
    """Bytes of a strike between certain silences."""
    seen = b""
    for piece, pause in strike.pieces:
        seen += piece
        if pause >= PAUSES.certain:
            yield seen
            seen = b""
    yield seen


def test_a_request_behind_anothers_reply_is_seen():
    """No strike carries what would be obeyed, wherever in it that begins."""
    generator = strikes.Generator(random.Random(5), 1, SAFETY, PAUSES)
    kinds = Counter()
    looked_at = 0
    for strike, _ in zip(generator, range(cases(1000, 3000)), strict=False):
        kinds[strike.kind] += 1
        for seen in stretches(strike):
            for start in range(len(seen)):
                behind_a_frame = seen[:start] in wire.frames_in(seen)
                for frame in wire.frames_in(seen[start:]):
                    if frame[0] in (0, 1) and (start == 0 or behind_a_frame):
                        assert SAFETY.harmless(frame), strike
                        looked_at += 1
    assert len(kinds) == 15
    assert looked_at > 300


def test_same_seed_same_strikes():
    def first(seed):
        generator = strikes.Generator(random.Random(seed), 1, SAFETY, PAUSES)
        return [strike for strike, _ in zip(generator, range(50), strict=False)]

    assert first(1) == first(1) != first(2)


def test_checksum():
    assert wire.crc16(b"123456789") == 0x4B37
    assert wire.seal(bytes.fromhex("01030000000A")).hex() == "01030000000ac5cd"
