# SPDX-License-Identifier: MIT
"""The synchronizer between a pin and PINx."""

import unittest

from harness import IMAGES, Session, SimTest, image, read_edges

SAMPLES = 16


class Synchronizer(SimTest):
    """images/synchronizer.c"""

    def go(self, board, commands=()):
        """The samples, and the cycle in which the first of them was taken."""
        path = self.folder / "edges.csv"
        with Session(image(board, "synchronizer"), options=["--edges", str(path)]) as sim:
            self.assertEqual(sim.ask("pin 0 C 3 0"), "ok")
            for command in commands:
                self.assertEqual(sim.ask(command), "ok", command)
            sim.run(5_000)
            samples, end = sim.results(2)
            self.assertEqual(end, 0x600D)
            sim.ask("flush")
        first = [row[0] for row in read_edges(path) if row[3:] == ("ENABLE", 1)]
        self.assertEqual(len(first), 1)
        return [samples >> (SAMPLES - 1 - n) & 1 for n in range(SAMPLES)], first[0]

    def test_a_level_is_read_a_cycle_behind_the_pin(self):
        """An IN that begins in the cycle of the change still reads the level before."""
        for board in IMAGES:
            samples, first = self.go(board)
            self.assertEqual(samples, [0] * SAMPLES)
            for n in range(-3, SAMPLES):
                samples, again = self.go(board, [f"pin 0 C 3 1 at {first + n}"])
                self.assertEqual(again, first)
                self.assertEqual(samples, [int(k > n) for k in range(SAMPLES)], (board, n))

    def test_a_pulse_of_one_cycle_is_one_sample(self):
        for board in IMAGES:
            _, first = self.go(board)
            pulse = [f"pin 0 C 3 1 at {first + 4}", f"pin 0 C 3 0 at {first + 5}"]
            samples, _ = self.go(board, pulse)
            self.assertEqual(samples, [int(k == 5) for k in range(SAMPLES)], board)

    def test_another_pins_edge_delays_nothing(self):
        """Each pin has a synchronizer of its own."""
        for board in IMAGES:
            _, first = self.go(board)
            for other in range(3, 8):
                edges = [f"pin 0 C 3 1 at {first + 5}", f"pin 0 C 2 1 at {first + other}"]
                samples, _ = self.go(board, edges)
                self.assertEqual(samples, [int(k > 5) for k in range(SAMPLES)], (board, other))


if __name__ == "__main__":
    unittest.main()
