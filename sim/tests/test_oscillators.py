# SPDX-License-Identifier: MIT
"""Oscillators of each board's own, ppm apart or of 16 and 20 MHz; all times are the bench's."""

import json
import unittest
from fractions import Fraction

from harness import Session, SimTest, image, read_edges, rising

MS = 16_000
AXES = (0, 0, 1)  # whose STEP images/capture.c makes, by board
OWN_PERIOD = 10_000  # of images/capture.c, in cycles of its board
TICK_MASK = 0x3FFF


class Oscillators(SimTest):
    def session(self, boards, *options):
        self.path = self.folder / "edges.csv"
        return Session(*boards, options=["--edges", str(self.path), *options])

    def last(self, sim, board, axis):
        """Return the cycle of the last STEP edge."""
        return int(sim.ask(f"last {board} {axis}").split()[3])

    def test_edges_are_in_the_benchs_time(self):
        boards = [
            image("uno", "capture"),
            image("uno", "capture"),
            image("m1284", "capture"),
        ]
        with self.session(boards, "--oscillator-ppm", "1=-5000") as sim:
            sim.run(100 * MS)
            sim.ask("flush")
            stats = json.loads(sim.ask("stats"))
            last = [self.last(sim, board, axis) for board, axis in enumerate(AXES)]
        edges = read_edges(self.path)
        self.assertEqual([edge[0] for edge in edges], sorted(edge[0] for edge in edges))
        for board, scale in enumerate((Fraction(1), Fraction(995, 1000), Fraction(5, 4))):
            cycles = rising(edges, AXES[board], board)
            period = OWN_PERIOD / scale
            self.assertEqual(len(cycles), int((100 * MS - cycles[0]) / period) + 1)
            off = [cycle - cycles[0] - k * period for k, cycle in enumerate(cycles)]
            self.assertTrue(max(off) - min(off) <= 1, (board, off))
            self.assertEqual(cycles[-1], last[board])
            self.assertEqual(
                stats["boards"][board]["axes"][AXES[board]]["steps_rising"], len(cycles)
            )

    def test_the_pixel_clock_comes_to_all_at_once(self):
        """Each board's timer sees the period of the clock in its own ticks."""
        boards = [
            image("uno", "capture"),
            image("uno", "capture"),
            image("m1284", "capture"),
        ]
        options = (
            "--oscillator-ppm",
            "1=4000",
            "--pixel-hz",
            "300",
            "--power-up-ms",
            "3",
        )
        with self.session(boards, *options) as sim:
            sim.run(189 * MS)
            seen = [sim.results(60, board) for board in range(3)]
        for (count, *ticks), scale in zip(seen, (1.0, 1.004, 1.25), strict=True):
            self.assertEqual(count, 54)  # the first 10 ms after the start
            period = 16_000_000 / 300 * scale
            ticks = [tick & TICK_MASK for tick in ticks[:count]]
            off = [
                (tick - ticks[0] - k * period + 5000) % OWN_PERIOD for k, tick in enumerate(ticks)
            ]
            self.assertTrue(all(abs(one - 5000) <= 2 for one in off), off)

    def test_frames_cross(self):
        """Boards 3 % apart, the master between them: each has the master for a partner."""
        boards = [image("uno", "echo"), image("mega", "echo"), image("uno", "echo")]
        options = ("--oscillator-ppm", "1=-15000", "--oscillator-ppm", "2=15000")
        with self.session(boards, *options) as sim:
            sim.run(MS)
            for address in (1, 2, 3):
                answer = sim.ask(f"tx 0{address}07").split()
                self.assertEqual(answer[1], f"0{address}08")
            begun = int(answer[2])
            # Four frames of which two are the board's, of 17 cycles * 8 * 11, and the silence.
            lasts = 2 * 11 * 16_000_000 / 115_200 + 2 * 11 * 136 / 1.015 + 1750 * 16
            self.assertAlmostEqual(begun - int(self.before(sim)), lasts, delta=300)

    def before(self, sim):
        """Return the cycle at which the same exchange again would have begun."""
        now = int(sim.ask("run 0").split()[1])
        again = int(sim.ask("tx 0307").split()[2])
        return 2 * now - again

    def test_commands_are_in_the_benchs_time(self):
        """A pin, a reset and a supply at a cycle of the bench, of a board of 20 MHz."""
        boards = [image("uno", "capture"), image("m1284", "capture")]
        with self.session(boards) as sim:
            sim.run(MS)
            first = self.last(sim, 1, 1)
            at = [first + 8000 * 10 + 1600, first + 8000 * 12 + 3200]
            for cycle in at:
                sim.ask(f"edge 1 pulse at {cycle}")
            sim.run(20 * MS)
            count, *ticks = sim.results(3, 1)
            self.assertEqual(count, 2)
            self.assertEqual((ticks[1] - ticks[0]) & TICK_MASK, 2000)
            self.assertEqual(sim.ask(f"cycle 1 at {30 * MS}"), "ok")
            sim.run(20 * MS)
            again = self.last(sim, 1, 1)
            since = [(again - 30 * MS - first) % 8000, 41 * MS - again]
            self.assertTrue(min(since[0], 8000 - since[0]) <= 10 and 0 <= since[1] <= 8000, since)
            now = int(sim.ask("reset 1 external").split()[1])
            self.assertTrue(0 <= now - 41 * MS <= 10)


if __name__ == "__main__":
    unittest.main()
