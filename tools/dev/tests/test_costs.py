# SPDX-License-Identifier: MIT
"""The table of costs fits the images, and a costlier image is guaranteed less."""

from dataclasses import asdict, replace
from fractions import Fraction

import pytest

from pixstep.board import boards, costs, guarantee
from pixstep_dev.costs import table


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", boards.BOARD_NAMES)
def test_the_table_fits_the_image(board):
    assert table.stale(board, table.measure(board)) == []


@pytest.mark.parametrize(
    ("name", "more"), [("step_isr", 20), ("even_px", 500), ("edge", 2000), ("low", 0.4)]
)
def test_a_costlier_image_is_told_and_guaranteed_less(monkeypatch, name, more):
    known = costs.of("mega")
    costlier = replace(known, **{name: getattr(known, name) + more})
    assert table.stale("mega", asdict(costlier)) == [
        f"mega: {name} costs {getattr(costlier, name):g}, the table has {getattr(known, name):g}"
    ]
    world = guarantee.LineConditions("mega", Fraction(1500))
    before = guarantee.rate("constant", 4, world, 40)
    monkeypatch.setattr(costs, "table", lambda: {"mega": costlier})
    assert guarantee.rate("constant", 4, world, 40) < before
