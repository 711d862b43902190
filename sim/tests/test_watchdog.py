# SPDX-License-Identifier: MIT
"""The watchdog model against the data sheet: timed sequence, prescalers, modes, resets."""

import unittest

from harness import Session, SimTest, differences, image, read_edges

CASE = 0x5F0
RESULTS = 40
SHORTEST = 256_000  # 2048 cycles of 128 kHz
MS = 16_000
PORF, EXTRF, WDRF = 1, 2, 8
RESPONSE = {"uno": 4, "mega": 5}
WDIF, WDIE, WDCE, WDE = 0x80, 0x40, 0x10, 0x08
LATEST = 40  # cycles of instructions between an event and what the log shows of it


class Guard(SimTest):
    """images/guard.c"""

    def go(self, case, cycles, board="uno"):
        """Results, and cycles of the PERMIT edges, of one case."""
        path = self.folder / "edges.csv"
        with Session(image(board, "guard"), options=["--edges", str(path)]) as sim:
            # The first words of a run are the paint of the stack watch.
            sim.ask("poke 0 0x600 " + "0000" * RESULTS)
            self.assertEqual(sim.ask(f"poke 0 {CASE} {case:02x}"), "ok")
            self.assertEqual(sim.run(cycles), f"ok {cycles}")
            sim.ask("flush")
            results = sim.results(RESULTS)
            self.assertEqual(sim.ask("permit 0").split()[1], str(len(read_edges(path)) % 2))
        return results, [e[0] for e in read_edges(path) if e[3] == "PERMIT"]

    def check_time(self, board, case, cycles):
        """From the last edge that the program makes to its pins' release by the reset."""
        results, edges = self.go(case, cycles + 100_000, board)
        self.assertEqual(results[:3], [2, PORF, WDRF])
        self.assertLessEqual(abs(edges[-1] - edges[-2] - cycles), LATEST)
        return results

    def check(self, board):
        results = self.check_time(board, 1, 2 * SHORTEST)
        self.assertEqual(results[30], WDE | 1)
        self.check_time(board, 2, SHORTEST)
        for wdp in range(6):
            self.check_time(board, 20 + wdp, SHORTEST << wdp)

    def test_sequence_and_prescalers_uno(self):
        self.check("uno")

    def test_sequence_and_prescalers_mega(self):
        self.check("mega")

    def test_longest(self):
        self.check_time("uno", 29, SHORTEST << 9)

    def test_runs_on_after_its_reset_until_turned_off(self):
        results, edges = self.go(1, 5_000_000)
        # It resets, then again after 16 ms because WDRF is still set; then it is turned off.
        self.assertEqual(results[:4], [3, PORF, WDRF, WDRF])
        self.assertEqual(results[17:20], [0, WDE, WDE])
        self.assertEqual(results[29], 0)
        self.assertEqual(len(edges), 2)

    def test_interrupts_only(self):
        results, edges = self.go(3, 2_000_000)
        self.assertEqual(results[0], 1)
        self.assertEqual(len(edges), 1 + 7)
        for gap in differences(edges[1:]):
            self.assertLessEqual(abs(gap - SHORTEST), LATEST)

    def test_every_period_to_the_cycle(self):
        """Out of a sleep each interrupt is answered as late as the one before."""
        for board in ("uno", "mega"):
            _, edges = self.go(10, 2_000_000, board)
            self.assertEqual(len(edges), 1 + 7)
            self.assertEqual(set(differences(edges[1:])), {SHORTEST})
            # mark() is in force 3 to 5 cycles before the STS that turns the watchdog on, the count
            # begins one behind it. Then the response, 4 more from sleep, a jump, LDI and OUT.
            late = edges[1] - edges[0] - SHORTEST - RESPONSE[board] - 4 - 2 - 1
            self.assertIn(late, range(4, 8), board)

    def test_what_answers_late_moves_no_period(self):
        """Out of a loop of three cycles each is answered as soon as the turn is over."""
        periods = 30
        for board in ("uno", "mega"):
            _, edges = self.go(12, (periods + 1) * SHORTEST + 30_000, board)
            self.assertEqual(len(edges), 2 + periods)
            gaps = differences(edges[1:])
            self.assertGreater(len(set(gaps)), 1)
            self.assertLessEqual(abs(edges[-1] - edges[1] - periods * SHORTEST), 3)

    def test_wdr_to_the_cycle(self):
        """The reset comes a whole period after WDR, at once out of a sleep."""
        for board in ("uno", "mega"):
            _, edges = self.go(11, 400_000, board)
            # WDR follows the OUT whose edge is one behind it, and counts from its own end.
            self.assertEqual(edges[1] - edges[0], SHORTEST + 1, board)

    def test_interrupt_then_reset(self):
        results, edges = self.go(4, 700_000)
        self.assertEqual(results[:3], [2, PORF, WDRF])
        # The program's own edge, the interrupt's, and none at the reset: PERMIT is low again.
        self.assertEqual(len(edges), 2)
        self.assertLessEqual(abs(edges[1] - edges[0] - SHORTEST), LATEST)

    def test_interrupt_not_served_then_reset(self):
        results, edges = self.go(5, 700_000)
        self.assertEqual(results[:3], [2, PORF, WDRF])
        self.assertLessEqual(abs(edges[1] - edges[0] - 2 * SHORTEST), LATEST)

    def test_fed(self):
        results, edges = self.go(6, 2_000_000)
        self.assertEqual(results[1:3], [PORF, WDRF])
        self.assertLessEqual(abs(edges[0] - 5 * 15 * MS), 200)
        self.assertLessEqual(abs(edges[1] - edges[0] - SHORTEST), LATEST)

    def test_a_shorter_prescaler_after_its_time(self):
        results, edges = self.go(7, 1_700_000)
        self.assertEqual(results[:3], [2, PORF, WDRF])
        self.assertLessEqual(edges[1] - edges[0], LATEST)

    def test_flag(self):
        results, _ = self.go(8, 400_000)
        self.assertEqual(results[30:32], [WDIF | WDIE, WDIE])
        # The lds reads in its second cycle: in the window's fourth and fifth.
        self.assertEqual(results[32:34], [WDCE, 0])

    def test_reserved(self):
        with Session(image("uno", "guard")) as sim:
            sim.ask("poke 0 0x600 " + "0000" * RESULTS)
            sim.ask(f"poke 0 {CASE} 09")
            answer = sim.run(10_000)
        self.assertIn("watchdog: WDP3:0 = 10 is reserved", answer)

    def test_other_resets(self):
        """An external reset turns it off, unless WDRF is still set."""
        with Session(image("uno", "guard")) as sim:
            sim.ask("poke 0 0x600 " + "0000" * RESULTS)
            sim.ask(f"poke 0 {CASE} 17")  # 64 ms << 1
            sim.run(100_000)
            # At the end of the instruction under way, a jump.
            self.assertIn(sim.ask("reset 0 external"), ("ok 100000", "ok 100001"))
            sim.run(4_000_000)
            self.assertEqual(sim.results(3), [2, PORF, EXTRF])
            self.assertEqual(sim.results(19)[18], 0)


if __name__ == "__main__":
    unittest.main()
