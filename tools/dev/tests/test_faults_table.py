# SPDX-License-Identifier: MIT
"""The table of faults, the tests that provoke them and docs/FAULTS.md are one and the same list."""

from pixstep import natives
from pixstep.board import registers
from pixstep_dev.docs import faults

FOLDER = natives.root() / faults.TESTS


def test_every_fault_is_provoked_and_nothing_else():
    table = {fault.name for fault in registers.faults().values() if fault.code}
    assert set(faults.provoking_tests(FOLDER)) == table


def test_the_marks_of_a_file(tmp_path):
    (tmp_path / "test_a.py").write_text(
        "import pytest\n"
        '@pytest.mark.provokes("one", "two")\n'
        '@pytest.mark.parametrize("board", ["uno"])\n'
        "def test_x(board): pass\n"
        '@pytest.mark.provokes("one")\n'
        "def test_y(): pass\n"
        "def test_z(): pass\n"
    )
    assert faults.provoking_tests(tmp_path) == {
        "one": ["test_a.py: test_x", "test_a.py: test_y"],
        "two": ["test_a.py: test_x"],
    }


def test_a_fault_that_is_only_claimed_fails(pytester):
    """The mark alone is not enough: the fault must have been asserted."""
    pytester.makeconftest('pytest_plugins = ["common_fixtures"]')
    pytester.makepyfile(
        """
        import faultbench, pytest

        @pytest.mark.provokes("starved")
        def test_claims(): pass

        @pytest.mark.provokes("starved")
        def test_shows(): faultbench.asserted.add("starved")

        @pytest.mark.provokes("starved", "reset")
        def test_shows_half(): faultbench.asserted.add("starved")
        """
    )
    pytester.syspathinsert(FOLDER)
    done = pytester.runpytest("-p", "no:cacheprovider")
    done.assert_outcomes(passed=3, errors=2)
    done.stdout.fnmatch_lines(["*never seen: {'starved'}*", "*never seen: {'reset'}*"])
