# SPDX-License-Identifier: MIT
"""What is accepted runs: random sets of lines about what boards are guaranteed to follow."""

import pytest

from effort import cases
from pixstep_dev.guarantee import campaign
from pixstep_dev.guarantee.campaign import GuaranteePlan


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize(("sets", "seed"), cases([(24, 1001)], [(400, 1002)]))
def test_accepted_sets_run_clean(sets, seed):
    outcome = campaign.run(GuaranteePlan(sets, seed))
    assert outcome.complaints == []
    accepted = [one for one in outcome.ended if one.accepted]
    assert len(accepted) >= sets // 3
