# SPDX-License-Identifier: MIT
"""One object runs lines on any link: a simulated board, and a board behind a port's client."""

from fractions import Fraction
from itertools import pairwise

import pytest

from fake_board import FakeBoard, FakeLine, FakeWorld
from pixstep.board import upload
from pixstep.board.errors import BoardError, LineRefusedByBoardError
from pixstep.board.link import Link, SerialLink
from pixstep.board.modbus import SimClient
from pixstep.lines.line import PLAIN, Line
from pixstep.simulation.simulated_board import BoardUnderTest, SimulatedBoard
from pixstep.simulation.simulator import SimulatorError

HZ = Fraction(100)
REST_S = 0.05  # between two polls of a board that runs
LINE = Line((20, 40, 40, 20), PLAIN)
LONG = Line(tuple(1 + pixel % 7 for pixel in range(300)), PLAIN)  # more entries than a queue holds


class Seen:
    """Reads no records; notes when each poll began, and how far the board was at the end."""

    def __init__(self, run):
        self.run, self.world, self.begun_s, self.pixels = run, None, [], 0

    def look_if_due(self, world, uploads):
        assert uploads == self.run.lines.uploads

    def look(self, uploads, *, ended=False):
        assert ended and not uploads
        self.pixels = self.run.lines.seen[0]["pixel"]

    def timed(self, world):
        """Return itself as the time, which ends each wait with another poll."""
        self.world = world
        return self

    def now_s(self):
        return self.world.now_s()

    def wait(self, seconds):
        self.world.wait(seconds)
        self.begun_s.append(self.world.now_s())


def connected():
    """Return a link like an open port's, with a fake board behind it, and the board."""
    world = FakeWorld()
    fake = FakeBoard(world, 1, "mega")
    link: Link = SerialLink(SimClient(FakeLine(world, fake)), "/dev/ttyTEST", world)
    return link, fake


@pytest.fixture(params=["simulated", "connected"])
def run(request):
    """Return a run on a simulated board, and on one behind a port."""
    if request.param == "connected":
        made = BoardUnderTest(connected()[0])
        made.board.pixel_period_s = lambda: float(1 / HZ)  # the fake measures no clock
        yield made
        return
    request.getfixturevalue("simulator")
    with SimulatedBoard("mega", HZ) as simulated:
        yield simulated


@pytest.mark.parametrize("line", [LINE, LONG], ids=["short", "streamed"])
def test_a_line_to_its_end(run, line):
    seen = Seen(run)
    run.set_up(HZ, [0], dir_setup_us=30)
    run.load({0: line})
    assert run.states() == {0: "loaded"}
    assert run.make(lambda: seen, seen.timed)
    assert run.states() == {0: "done"}
    assert run.uploads[0].done
    assert run.board.axis(0)["position_steps"] == line.total_steps
    assert run.board.read_holdings(run.board.map.holding("dir_setup_us").address, 1) == [30]
    assert seen.pixels == line.pixels
    gaps = [b - a for a, b in pairwise(seen.begun_s)]
    assert (line is LINE or len(gaps) > 1) and all(gap >= 0.999 * REST_S for gap in gaps)


@pytest.mark.parametrize(("line", "sooner"), [(LINE, False), (LONG, True)])
def test_a_queue_of_fast_pixels_is_fed_before_it_is_half_empty(line, sooner):
    run = BoardUnderTest(connected()[0])
    run.set_up(Fraction(8000), [0])
    run.load({0: line})
    queued_s = run.uploads[0].queued_pixels / 8000
    pause_s = upload.pause_s(run.uploads.values(), 1 / 8000, REST_S)
    assert pause_s == (pytest.approx(0.3 * queued_s) if sooner else REST_S)
    assert queued_s < 2 * REST_S


@pytest.mark.usefixtures("simulator")
def test_a_refused_line():
    with SimulatedBoard("uno", HZ) as run:
        run.set_up(HZ, [0])
        with pytest.raises(LineRefusedByBoardError, match="too_fast"):
            run.load({0: Line((12_000,) * 3, PLAIN)})


def test_an_axis_that_does_not_load():
    link, fake = connected()
    run = BoardUnderTest(link)
    run.set_up(HZ, [0])
    queue = fake.queue

    def lose_the_end(words):
        queue(words)
        fake.axes[0].state = "loading"

    fake.queue = lose_the_end
    with pytest.raises(BoardError, match="axis 0: loading after the upload, not loaded"):
        run.load({0: LINE})


def test_a_line_that_never_starts_is_not_waited_for_forever():
    link, fake = connected()
    run = BoardUnderTest(link)
    run.set_up(HZ, [0])
    run.load({0: LINE})
    fake.start = lambda _: None
    run.arm()
    begun_s = link.world.now_s()
    assert not run.make(armed=True)
    assert run.states() == {0: "armed"}
    assert 0.1 < link.world.now_s() - begun_s < 1


@pytest.mark.usefixtures("simulator")
def test_a_simulated_board_ends_with_its_block_and_its_files_are_whole(tmp_path):
    edges = tmp_path / "edges.csv"
    with SimulatedBoard("uno", HZ, edges=edges) as run:
        run.set_up(HZ, [0])
        run.load({0: LINE})
        assert run.make()
        run.settle()
        run.finish()
    assert edges.read_text().count(",STEP,1\n") == LINE.total_steps
    with pytest.raises(SimulatorError):
        run.simulator.stats()
