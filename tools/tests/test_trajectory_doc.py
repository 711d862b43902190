# SPDX-License-Identifier: MIT
"""docs/TRAJECTORIES.md: its table is the model's."""

import re
from fractions import Fraction

from pixstep import natives
from pixstep.trajectories import transitions
from pixstep.trajectories.transitions import Servo

TEXT = (natives.root() / "docs" / "TRAJECTORIES.md").read_text(encoding="utf-8")
_CELL = re.compile(r"(?:(\d+): )?(\d\.\d{6})")
IN = 1_638_400


def test_the_table_of_transitions_is_the_model_s():
    machines = [
        (radius, point_s, servo)
        for radius, point_s in ((102_400, 81.81 / 8192), (3_276_800, 150.8 / 8192))
        for servo in (None, Servo(5, 0.4), Servo(10, 0.6))
    ]
    rows = [row.split("|")[1:-1] for row in TEXT.splitlines() if re.match(r"\| (\d|`auto`)", row)]
    assert len(rows) == 6
    for first, *cells in rows:
        for cell, (radius, point_s, servo) in zip(cells, machines, strict=True):
            found = _CELL.fullmatch(cell.strip())
            if found is None:
                assert servo is None and first.strip() == "`auto`"
                continue
            crest = transitions.Crest(radius, 8192, 7485, point_s, servo)
            steps = int(found[1] or first)
            places = transitions.BETWEEN if found[1] else 1
            error = transitions.predicted_error(crest, steps, places) / IN
            assert f"{error:.6f}" == found[2], (steps, servo)
            if found[1]:
                assert transitions.choose(crest).steps == steps


def test_the_document_s_clock_is_the_published_one():
    assert abs(Fraction("100.13") * Fraction("81.81") - 8192) < 1
