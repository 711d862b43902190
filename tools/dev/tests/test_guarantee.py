# SPDX-License-Identifier: MIT
"""What is accepted runs: random sets of lines about what boards are guaranteed to follow."""

import pytest

from effort import LONG, cases
from pixstep_dev.guarantee import campaign, rates, sweeps
from pixstep_dev.guarantee.campaign import GuaranteePlan


class TooFast(rates.RatedLine):
    """A line that no board is guaranteed."""

    steps = 780


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize(("sets", "seed"), cases([(24, 1001)], [(400, 1002)]))
def test_accepted_sets_run_clean(sets, seed):
    outcome = campaign.run(GuaranteePlan(sets, seed))
    assert outcome.complaints == []
    accepted = [one for one in outcome.ended if one.accepted]
    assert len(accepted) >= sets // 3


@pytest.mark.usefixtures("simulator")
def test_lines_at_the_guaranteed_rates_run_beside_a_saturated_bus():
    """A request may come at the moment at which a ring is lowest."""
    few = [rates.RatedLine("uno", 1, "start", "smooth", 100, baud) for baud in rates.BAUDS]
    few.append(rates.RatedLine("mega", 4, "lock", "constant", 100))
    outcome = rates.run(rates.rated() if LONG else few, cases(2, 1))
    assert outcome.complaints == []


@pytest.mark.usefixtures("simulator")
def test_a_line_above_its_guaranteed_rate_is_seen_to_fail():
    """The highest rate that was seen to run once is no guarantee."""
    outcome = rates.run([TooFast("uno", 1, "start", "smooth", 100)], 2)
    assert len(outcome.complaints) == 2


def test_a_slower_clock_is_promised_no_fewer_steps_a_pixel():
    swept = sweeps.run(clocks_hz=sweeps.CLOCKS_HZ if LONG else sweeps.CLOCKS_HZ[10:18:2])
    assert swept.dips == []


def test_a_dip_is_found_beside_every_faster_clock():
    lines = [rates.RatedLine("uno", 1, "start", "smooth", hz) for hz in (20, 40, 80, 160)]
    steps = dict(zip(lines, (100, 55, 79, 60), strict=True))
    (dip,) = sweeps.dips(lines, steps)
    assert str(dip) == "uno 1 start smooth 40 Hz 115200 baud: 55 steps/px, but 79 at 80 Hz"


@pytest.mark.parametrize(("faster_steps", "of_ramps"), [(300, True), (600, False)])
def test_a_dip_is_of_ramps_where_the_faster_clocks_line_is_followed(faster_steps, of_ramps):
    line = rates.RatedLine("mega", 4, "lock", "ramp", 49)
    assert sweeps.Dip(line, 30, 66, faster_steps).of_ramps == of_ramps
