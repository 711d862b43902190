# SPDX-License-Identifier: MIT
"""The record block as the host reads it."""

from pixstep.board import registers as regs
from pixstep.board.state import parse_records


def block(newest, made, rows):
    """Return the block's registers; rows: (pixel, expected, actual, error)."""
    words = [newest >> 16, newest & 0xFFFF, len(rows), made]
    for pixel, expected, actual, error in rows:
        words += [pixel & 0xFFFF]
        for steps in (expected, actual):
            words += [steps >> 16 & 0xFFFF, steps & 0xFFFF]
        words += [error & 0xFFFF]
    return words


def test_records_have_their_whole_pixel():
    found = parse_records(
        block(65_537, 65_537, [(65_536, -7, -8, -1), (65_537, 70_000, 70_001, 2)])
    )
    assert found.made == 65_537
    assert [
        (r.pixel, r.expected_steps, r.actual_steps, r.edge_error_ticks) for r in found.records
    ] == [
        (65_536, -7, -8, -1),
        (65_537, 70_000, 70_001, 2),
    ]


def test_records_of_the_line_before_are_left_out():
    assert parse_records(block(0, 0, [(7, 70, 70, 0), (8, 80, 80, 0)])).records == []


def test_a_block_without_records():
    words = block(0, 0, []) + [0] * regs.RECORD_REGISTERS
    assert parse_records(words).records == []
