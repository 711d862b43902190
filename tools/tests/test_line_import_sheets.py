# SPDX-License-Identifier: MIT
"""Spreadsheet exports as people have them: read right, or refused with a way in."""

import random
from collections import Counter
from fractions import Fraction

from effort import cases
from pixstep.errors import RefusedError
from pixstep.lines.line import PLAIN
from pixstep.lines.units import MM, Scale
from pixstep.owndata import import_line
from spreadsheets import STEPS_PER_MM, sheet, spoiled

SCALE = Scale(Fraction(STEPS_PER_MM), MM)
SOUND, SPOILED = cases((700, 300), (14_000, 6000))
WAYS_IN = ("can be read as ", "choose one by column", "say what it holds", "decimal says which")


def read(made, place, *, told=False):
    """Return the counts of a table, or the words of its refusal."""
    place.write_bytes(made.data)
    try:
        return import_line(place, made.request(PLAIN, SCALE, told=told)).line.counts, ""
    except RefusedError as error:
        return None, str(error)


def test_sound_tables_are_read_right_or_refused_with_a_way_in(tmp_path):
    rng, place, outcomes = random.Random("sheets"), tmp_path / "sheet.csv", Counter()
    for number in range(SOUND):
        made = sheet(rng)
        counts, said = read(made, place)
        what = f"{number}: {made}\n{said}"
        assert counts in (None, made.counts), what
        assert not said or any(words in said for words in WAYS_IN), what
        outcomes[next((words for words in WAYS_IN if words in said), "read")] += 1
        if counts is None:
            counts, said = read(made, place, told=True)
            assert counts == made.counts, f"{what}\ntold: {said}"
    assert outcomes["read"] > 0.7 * SOUND, outcomes
    assert outcomes["can be read as "] > 0.02 * SOUND, outcomes


def test_spoiled_tables_never_make_a_wrong_line(tmp_path):
    rng, place = random.Random("spoiled"), tmp_path / "sheet.csv"
    for number in range(SPOILED):
        made = spoiled(rng)
        counts, said = read(made, place)
        assert counts is None, f"{number}: {made}\n{counts}"
        assert said.startswith(str(place)) and "\n" not in said
