# SPDX-License-Identifier: MIT
"""Fly scans: what is tried with bluesky and scanspec, and what is said where they are missing."""

import pytest

import pixstep as px
from client_runs import run_tests
from pixstep.fly.flyer import LineFlyer


def test_with_bluesky_and_scanspec():
    assert " passed" in run_tests("fly_scanspecs.py", "fly_scans.py")


@pytest.mark.usefixtures("simulator")
def test_a_flyer_names_the_extra_that_it_needs(monkeypatch):
    monkeypatch.setattr("pixstep.lazy.have_package", lambda name: False)
    with px.simulated_board("uno", pixel_hz=100) as board:
        line = px.line([2, 6, 8, 6, 2], pixel_hz=100)
        with pytest.raises(px.UserError, match=r"need bluesky: pip install 'pixstep\[bluesky\]'"):
            LineFlyer(board, line)


def test_what_is_no_scanspec_is_refused():
    with pytest.raises(px.UserError, match=r"spec 7: expected a spec of scanspec\.specs"):
        px.fly.line_from_scanspec(7, pixel_hz=100)
