# SPDX-License-Identifier: MIT
"""How much of a clock's jitter a locked line may let through: STEP edges lie on whole ticks."""

from types import SimpleNamespace

import numpy as np
import pytest

from pixstep.simulation import clock_judge
from pixstep.simulation.pixel_clock import ClockFlaws

TICK_HZ = 16_000_000


def kept(rms_ticks):
    return SimpleNamespace(pixels=np.arange(1000), rms_ticks=rms_ticks)


@pytest.mark.parametrize(
    ("jitter_ticks", "rms_ticks", "fine"),
    [(0.24, 0.45, True), (0.24, 0.50, False), (80, 79, True), (80, 81, False)],
)
def test_rounding_to_ticks_is_no_jitter_let_through(jitter_ticks, rms_ticks, fine):
    job = SimpleNamespace(
        flaws=ClockFlaws(jitter_us=jitter_ticks / TICK_HZ * 1e6), locked=True, tick_hz=TICK_HZ
    )
    assert (clock_judge.reasons(job, kept(rms_ticks)) == []) == fine
