# SPDX-License-Identifier: MIT
"""Faults made to order, and the image's symbols."""

import json
import unittest

from harness import Session, SimTest, differences, image, read_edges, rising

BOARDS = ("uno", "mega")


class Hang(SimTest):
    """images/power.c: rounds counts the main loop's turns, overflows timer 1's interrupts."""

    def setUp(self):
        super().setUp()
        self.path = self.folder / "edges.csv"

    def open(self, board):
        return Session(image(board, "power"), options=["--edges", str(self.path)])

    def counts(self, sim):
        """What main loop and step interrupt have done."""
        words = [bytes.fromhex(sim.ask(f"peek 0 {s}")[4:]) for s in ("rounds", "overflows")]
        return [int.from_bytes(word, "little") for word in words]

    def moved(self, sim):
        """Which of the two move now."""
        before = self.counts(sim)
        sim.run(20_000)
        return [a != b for a, b in zip(before, self.counts(sim), strict=True)]

    def hung(self, board, what, moved):
        with self.open(board) as sim:
            sim.run(20_000)
            self.assertEqual(self.moved(sim), [True, True])
            self.assertTrue(sim.ask(f"hang 0 {what}").startswith("ok "), what)
            sim.run(100)
            self.assertEqual(self.moved(sim), moved, what)
            self.assertTrue(sim.ask("reset 0 external").startswith("ok "))
            sim.run(20_000)
            self.assertEqual(self.moved(sim), [True, True])
            sim.ask(f"hang 0 {what} kept")
            sim.ask("reset 0 external")
            sim.run(20_000)
            self.assertEqual(self.moved(sim)[0], moved[0], what)
            sim.ask("cycle 0")
            sim.run(20_000)
            self.assertEqual(self.moved(sim), [True, True])
            sim.ask(f"hang 0 {what}")
            sim.ask("hang 0 off")
            sim.run(20_000)
            self.assertEqual(self.moved(sim), [True, True])

    def test_each(self):
        for board in BOARDS:
            self.hung(board, "main", [False, True])
            self.hung(board, "interrupts", [False, False])
            self.hung(board, "axis 0", [True, False])

    def test_at_a_symbol(self):
        with self.open("mega") as sim:
            sim.ask("hang 0 at one_round")
            sim.run(20_000)
            self.assertEqual(self.moved(sim), [False, True])
            space, address, _ = sim.ask("symbol 0 one_round").split()[1:]
            self.assertEqual(space, "flash")
            sim.ask("hang 0 off")
            sim.run(1_000)
            self.assertEqual(self.moved(sim), [True, True])
            self.assertEqual(sim.ask(f"hang 0 at {address}"), "ok 61000")

    def test_interrupts_go_on_to_the_cycle(self):
        """The main program's hang changes no step; the handler's latency stays that of a jump."""
        with self.open("uno") as sim:
            sim.run(20_000)
            sim.ask("hang 0 main")
            sim.ask("mark")
            sim.run(100_000)
            sim.ask("flush")
            stats = json.loads(sim.ask("stats"))["boards"][0]
        self.assertEqual(set(differences(rising(read_edges(self.path)))), {1000})
        handler = next(h for h in stats["handlers"] if h["name"] == "TIMER1_OVF")
        self.assertEqual(handler["count"], 100)
        self.assertLessEqual(handler["latency_max"], 1 + 20)

    def test_a_processor_that_stands_still_delays_an_interrupt_and_no_edge(self):
        with self.open("uno") as sim:
            sim.run(20_000)
            main, interrupts = self.counts(sim)
            sim.ask("mark")
            ended = int(sim.ask("hang 0 for 990").split()[1])
            self.assertIn(ended, range(20_990, 21_050))
            self.assertEqual(self.counts(sim), [main, interrupts])
            sim.run(100_000)
            sim.ask("flush")
            stats = json.loads(sim.ask("stats"))["boards"][0]
            self.assertGreaterEqual(self.counts(sim)[1], interrupts + 100)
        self.assertEqual(set(differences(rising(read_edges(self.path)))), {1000})
        handler = next(h for h in stats["handlers"] if h["name"] == "TIMER1_OVF")
        self.assertIn(handler["latency_max"], range(21, 991))

    def test_errors(self):
        with self.open("uno") as sim:
            for wrong in (
                "nothing",
                "for",
                "for ever",
                "for 100001",
                "axis",
                "axis 1",
                "at nowhere",
                "at rounds",
                "at 0x1",
                "at 0x8000",
            ):
                answer = sim.ask(f"hang 0 {wrong}")
                self.assertTrue(answer.startswith("error "), answer)
            sim.run(20_000)
            self.assertEqual(self.moved(sim), [True, True])


class Symbols(unittest.TestCase):
    def test_memory_by_name(self):
        for board in BOARDS:
            with Session(image(board, "power")) as sim:
                sim.run(10_000)
                space, address, size = sim.ask("symbol 0 known").split()[1:]
                self.assertEqual((space, size), ("ram", "1"))
                self.assertEqual(sim.ask("peek 0 known"), "mem 01")
                self.assertEqual(sim.ask(f"peek 0 {address} 1"), "mem 01")
                self.assertEqual(sim.ask("poke 0 known 33"), "ok")
                self.assertEqual(sim.ask("peek 0 known 1"), "mem 33")
                before = sim.ask("peek 0 overflows 2").split()[1]
                self.assertEqual(sim.ask("peek 0 overflows+1"), f"mem {before[2:]}")
                self.assertEqual(sim.ask("peek 0 overflows+1 1"), f"mem {before[2:]}")

    def test_errors(self):
        with Session(image("uno", "power")) as sim:
            self.assertIn("no symbol 'nowhere'", sim.ask("peek 0 nowhere"))
            self.assertIn("'main' is in flash, not in ram", sim.ask("peek 0 main"))
            self.assertIn("how many bytes", sim.ask("peek 0 0x100"))
            self.assertIn("how many bytes", sim.ask("peek 0 _end"))
            self.assertIn("beyond", sim.ask("peek 0 known+5000 1"))
            self.assertIn("no symbol", sim.ask("symbol 0 x"))


if __name__ == "__main__":
    unittest.main()
