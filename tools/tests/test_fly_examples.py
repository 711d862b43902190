# SPDX-License-Identifier: MIT
"""The examples of fly scans."""

from client_runs import run_tests


def test_examples_with_bluesky_and_scanspec():
    assert "2 passed" in run_tests("fly_examples.py")
