# SPDX-License-Identifier: MIT
"""Packed queue entries, and blocks of them on their way to a board."""

import random

import pytest

from pixstep.lines import runs


@pytest.mark.parametrize(
    ("entry", "last", "data"),
    [
        ((100, 1), None, "80640001"),
        ((100, 1), 100, "38"),
        ((156, 1), 100, "70"),
        ((44, 1), 100, "00"),
        ((157, 1), 100, "7c39"),
        ((43, 1), 100, "7bc7"),
        ((1123, 1), 100, "7fff"),
        ((-924, 1), 100, "7800"),
        ((1124, 1), 100, "84640001"),
        ((-925, 1), 100, "fc630001"),
        ((227, 2), 100, "717f"),
        ((-28, 7), 100, "7680"),
        ((228, 2), 100, "80e40002"),
        ((100, 8), 100, "770008"),
        ((99, 255), 100, "77ffff"),
        ((100, 256), 100, "80640100"),
        ((2, 0), 2, "80020000"),
        ((32766, 32766), None, "fffe7ffe"),
        ((16383, 65535), -16384, "bfffffff"),
    ],
)
def test_forms(entry, last, data):
    packed, base = runs.pack(entry, last)
    assert packed.hex() == data
    assert base == runs.signed(entry[0], 15)
    assert runs.unpack(packed, last or 0) == [(base, entry[1])]


def test_what_is_packed_is_unpacked():
    rng = random.Random(5)
    for spread in (3, 50, 1000, 16000):
        entries = []
        last = None
        data = b""
        for _ in range(2000):
            count = max(-16383, min(16383, (last or 0) + rng.randint(-spread, spread)))
            entries.append((count, rng.choice([1, 1, 1, 2, 9, 300, 0])))
            piece, last = runs.pack(entries[-1], last)
            data += piece
        assert runs.unpack(data) == entries


@pytest.mark.parametrize("data", ["80", "806400", "7700", "71", "3878"])
def test_bytes_that_end_inside_an_entry(data):
    with pytest.raises(ValueError, match="inside an entry"):
        runs.unpack(bytes.fromhex(data))


def test_single_pixels_take_a_byte_each():
    rng = random.Random(6)
    entries = [(0x21, 0), (0, 0), *((rng.randint(10, 20), 1) for _ in range(1000)), (2, 0)]
    assert runs.packed_size(entries) == 8 + 1000 + 4
