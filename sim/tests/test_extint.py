# SPDX-License-Identifier: MIT
"""External interrupts, and pins driven at cycles to come."""

import unittest

from harness import GPIOR2, Session, SimTest, image, read_edges

PIN = {"uno": "D 2", "mega": "D 3", "m1284": "B 2"}
FLAG = {"uno": 1, "mega": 8, "m1284": 4}  # INTF in EIFR
RESPONSE = {"uno": 4, "mega": 5, "m1284": 4}
SYNC = 3
RJMP = 2
SBI = 2  # it writes in its second cycle, in force one later
RISING, FALLING, ANY = 3, 2, 1
TURNS = ((20_000, 0), (30_001, 1), (40_002, 0), (50_003, 1))  # the pin is pulled up


class Edges(SimTest):
    """images/extint.c"""

    def go(self, board, what, commands=(), cycles=100_000):
        path = self.folder / "edges.csv"
        with Session(image(board, "extint"), options=["--edges", str(path)]) as sim:
            sim.ask(f"poke 0 {GPIOR2} {what:02x}")
            for command in commands:
                self.assertEqual(sim.ask(command), "ok", command)
            answer = sim.run(cycles)
            results = sim.results(4)
            sim.ask("flush")
        rows = read_edges(path)
        return answer, results, [e[0] for e in rows if e[3:] == ("ENABLE", 1)]

    def turns(self, board):
        return [f"pin 0 {PIN[board]} {level} at {cycle}" for cycle, level in TURNS]

    def check_sense(self, board, sense, levels):
        _, _, seen = self.go(board, sense, self.turns(board))
        wanted = [cycle for cycle, level in TURNS if level in levels]
        self.assertEqual(len(seen), len(wanted))
        for edge, at in zip(seen, wanted, strict=True):
            # The instruction under way ends first: a nop, or a jump of two cycles.
            least = at + SYNC + RESPONSE[board] + RJMP + SBI
            self.assertIn(edge, (least, least + 1))

    def test_each_sense(self):
        for board in PIN:
            self.check_sense(board, FALLING, (0,))
            self.check_sense(board, RISING, (1,))
            self.check_sense(board, ANY, (0, 1))

    def test_a_request_that_is_cleared_while_it_waits(self):
        for board in PIN:
            _, _, seen = self.go(board, FALLING | 0x80, self.turns(board)[:1])
            self.assertEqual(seen, [])

    def test_every_cycle(self):
        """Wherever in the main program's loop the edge falls, the answer is as late."""
        lateness = set()
        for at in range(20_000, 20_010):
            _, _, seen = self.go("uno", FALLING, [f"pin 0 D 2 0 at {at}"], 21_000)
            lateness.add(seen[0] - at)
        least = SYNC + RESPONSE["uno"] + RJMP + SBI
        self.assertEqual(lateness, {least, least + 1})

    def test_edges_within_the_synchroniser_are_one_request(self):
        """It comes when the first of them has passed, however many follow it there."""
        for board in PIN:
            for sense, first in ((ANY, 0), (FALLING, 0), (RISING, 1)):
                levels = ((20_000, 0), (20_001, 1), (20_002, 0), (40_000, 1))
                commands = [f"pin 0 {PIN[board]} {level} at {cycle}" for cycle, level in levels]
                _, _, seen = self.go(board, sense, commands, cycles=30_000)
                least = 20_000 + first + SYNC + RESPONSE[board] + RJMP + SBI
                self.assertEqual(len(seen), 1, (board, sense))
                self.assertIn(seen[0], (least, least + 1), (board, sense))

    def test_an_edge_behind_the_synchroniser_is_another_request(self):
        levels = ((20_000, 0), (20_000 + SYNC + 1, 1))
        commands = [f"pin 0 {PIN['uno']} {level} at {cycle}" for cycle, level in levels]
        _, _, seen = self.go("uno", ANY, commands, cycles=30_000)
        self.assertEqual(len(seen), 2)

    def test_flag_without_interrupt(self):
        for board in PIN:
            command = [f"pin 0 {PIN[board]} 0 at 1000"]
            _, results, seen = self.go(board, 0x10 | FALLING, command)
            self.assertEqual(results, [FLAG[board], FLAG[board], 0, 0x600D])
            self.assertEqual(seen, [])
            _, results, seen = self.go(board, 0x10 | RISING, command)
            self.assertEqual(results[0], 0)

    def test_a_waiting_flag_interrupts_when_enabled(self):
        _, _, seen = self.go("uno", 0x30 | FALLING, ["pin 0 D 2 0 at 1000"])
        self.assertEqual(len(seen), 1)
        self.assertGreater(seen[0], 5000)

    def test_an_output_interrupts_whatever_drives_its_pin(self):
        """ "The interrupts will trigger even if the INT pins are configured as outputs"."""
        for board in PIN:
            for level in (0, 1):
                commands = [f"pin 0 {PIN[board]} {level}"]
                _, _, seen = self.go(board, 0x40 | RISING, commands, cycles=20_000)
                self.assertEqual(len(seen), 1, (board, level))
                self.assertGreater(seen[0], 5000)

    def test_low_level_is_refused(self):
        answer, _, _ = self.go("mega", 0)
        self.assertIn("INT3: low level (ISC31:0 = 0) is not modelled", answer)


class Planned(SimTest):
    def test_order_and_errors(self):
        with Session(image("uno", "echo")) as sim:
            sim.run(1_000)
            self.assertIn("is over, it is 1000", sim.ask("pin 0 D 2 0 at 999"))
            self.assertIn("expected 'at CYCLE'", sim.ask("pin 0 D 2 0 in 999"))
            self.assertIn("expected 'at CYCLE'", sim.ask("pin 0 D 2 0 at"))
            for _ in range(256):
                self.assertEqual(sim.ask("pin 0 C 3 1 at 5000"), "ok")
            self.assertIn("more than 256", sim.ask("pin 0 C 3 1 at 5000"))
            self.assertEqual(sim.run(10_000), "ok 11000")
            # In the same cycle: the one that was asked for last is last.
            for level in (0, 1, 0):
                sim.ask(f"pin 0 C 3 {level} at 12000")
            sim.run(500)
            self.assertEqual(sim.ask("peek 0 0x26 1"), "mem 08")  # PINC
            sim.run(1_000)
            self.assertEqual(sim.ask("peek 0 0x26 1"), "mem 00")


if __name__ == "__main__":
    unittest.main()
