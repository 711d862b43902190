# SPDX-License-Identifier: MIT
"""Lines that say how many clock edges a pixel has, on the images: orders, blocks and edges."""

from fractions import Fraction
from itertools import pairwise

import pytest

from bench import Bench
from pixstep.board import registers as regs
from pixstep.board.errors import BusyError, LineRefusedByBoardError
from pixstep.board.upload import LineUpload
from pixstep.lines import runs
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.runs import MARK_DIVIDER, queue_entries
from pixstep.simulation.logs import read_edges

pytestmark = pytest.mark.usefixtures("simulator")

HZ = Fraction(1000)
LINE = Line((20, 12, 20), PLAIN)
LONG = Line((20,) * 300, PLAIN)
DEFAULT = 1


@pytest.fixture(params=["m1284", "mega"])
def bench(request, tmp_path):
    with Bench(request.param, (0, 1), HZ, edges=tmp_path / "edges.csv") as made:
        yield made


@pytest.fixture
def mega():
    with Bench("mega", (0, 1), HZ) as made:
        yield made


def load(bench, line, divider, axis=0):
    """Upload a line with its divider."""
    upload = LineUpload(bench.board, axis, queue_entries(line, divider))
    upload.push()
    return upload


def edges_of(bench):
    """Return the setting, which the register of the period must agree with."""
    found = bench.board.setting("divider")
    ticks = int(Fraction(bench.sim.tick_hz) * found / HZ)
    assert bench.board.input("pixel_period_ticks") == ticks
    return found


def refused(bench, line, divider, axis=0):
    """A line with this divider is refused for it, and nothing changes."""
    before = edges_of(bench)
    with pytest.raises(LineRefusedByBoardError) as caught:
        load(bench, line, divider, axis)
    assert (caught.value.name, caught.value.pixel) == ("divider", 1)
    assert edges_of(bench) == before


def forget(bench, axis=0):
    bench.board.command("discard", [axis])
    bench.until(lambda: bench.state(axis) == "empty")


@pytest.mark.parametrize("decode", [PLAIN, SMOOTH])
def test_a_line_runs_by_the_pixels_that_it_says(bench, decode):
    line = Line((1, 3, 3, 1), decode)
    load(bench, line, 7)
    assert edges_of(bench) == 7
    bench.board.command("arm", [0])
    bench.until(lambda: bench.state() == "done")
    bench.assert_rest()
    assert bench.sim.steps(0, 0) == 8
    bench.sim.command("flush")
    made = read_edges(bench.edges_path).axis(0, 0).rising
    pixel = 7 * bench.pixel_ticks
    # The last step of each pixel is on the pixel's edge.
    last = [int(made[sum(line.counts[: number + 1]) - 1]) for number in range(4)]
    assert all(abs(later - earlier - pixel) <= 1 for earlier, later in pairwise(last))


def test_blocks_of_any_size(bench):
    entries = queue_entries(LINE, 3)
    for size in range(1, len(entries)):
        for packed in (False, True):
            bench.board.write_setting("divider", DEFAULT)
            block = bench.board.axis(0)["next_block"]
            for part in (entries[:size], entries[size:]):
                if packed:
                    data = b"".join(runs.pack(entry)[0] for entry in part)
                    bench.board.write_packed(0, block, data)
                else:
                    bench.board.write_block(0, block, part)
                block += 1
            assert bench.state() == "loaded"
            assert edges_of(bench) == 3
            forget(bench)


@pytest.mark.parametrize("divider", [0, 1001, 16_384, 32_767])
def test_what_the_setting_cannot_be(bench, divider):
    refused(bench, LINE, divider)
    assert bench.state() == "refused"
    forget(bench)
    load(bench, LINE, 800)
    assert edges_of(bench) == 800


def test_behind_a_line_only_its_own_number(bench):
    load(bench, LONG, 2)
    refused(bench, LINE, 3)
    forget(bench)
    load(bench, LONG, 2)
    bench.board.command("arm", [0])
    refused(bench, LINE, 3)
    bench.run_until_steps(10)
    refused(bench, LINE, 3)
    load(bench, LINE, 2)
    bench.until(lambda: bench.state() in ("loaded", "done"))
    bench.assert_rest()
    assert bench.sim.steps(0, 0) == 300 * 20
    bench.board.command("arm", [0])
    bench.until(lambda: bench.state() == "done")
    assert bench.sim.steps(0, 0) == 300 * 20 + 52


def test_a_refused_block_leaves_the_setting(bench):
    entries = [*queue_entries(LINE, 3)[:-1], (0, 0)]
    with pytest.raises(LineRefusedByBoardError, match="malformed"):
        LineUpload(bench.board, 0, entries).push()
    assert edges_of(bench) == DEFAULT


def test_cut_off_before_its_divider(bench):
    head = queue_entries(LINE, 5)[:2]
    LineUpload(bench.board, 0, head).push()
    assert bench.state() == "loading"
    bench.board.write_setting("divider", 4)  # nothing was checked by it
    forget(bench)
    load(bench, LINE, None)
    assert edges_of(bench) == 4


def test_settings_stay_from_the_first_segment_on(bench):
    load(bench, LINE, 3)
    with pytest.raises(BusyError, match="has a line loaded"):
        bench.board.write_setting("divider", 4)
    bench.board.command("arm", [0])
    with pytest.raises(BusyError):
        bench.board.write_setting("divider", 4)
    assert edges_of(bench) == 3


def test_clear_and_stop_leave_it(bench):
    load(bench, LONG, 3)
    bench.board.command("arm", [0])
    bench.run_until_steps(10)
    bench.board.command("stop", [0])
    bench.until(lambda: bench.state() == "empty")
    assert edges_of(bench) == 3
    load(bench, LINE, 4)
    bench.board.command("arm", [0])
    bench.until(lambda: bench.state() == "done")
    assert edges_of(bench) == 4


def test_beside_a_queued_or_moving_axis(mega):
    for state in ("loading", "loaded", "armed", "running"):
        LineUpload(
            mega.board, 1, queue_entries(LONG, 2)[: 4 if state == "loading" else None]
        ).push()
        if state in ("armed", "running"):
            mega.board.command("arm", [1], 5 if state == "armed" else 0)
        if state == "running":
            mega.run_until_steps(10, axis=1)
        assert mega.state(1) == state
        refused(mega, LINE, 3)
        mega.board.command("discard", [0])
        load(mega, LINE, 2)
        mega.board.command("discard", [0])
        if state != "running":
            mega.board.command("discard", [1])
            mega.until(lambda: mega.state(1) == "empty")
    mega.until(lambda: mega.state(1) == "done")
    assert mega.sim.steps(0, 1) == 300 * 20
    load(mega, LINE, 3)
    assert edges_of(mega) == 3


def test_a_board_tells_that_it_takes_dividers(bench):
    assert bench.board.has("line_divider")
    assert queue_entries(LINE, 3)[0][0] & MARK_DIVIDER
    assert regs.line_errors()[20].name == "divider"
