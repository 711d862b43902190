# SPDX-License-Identifier: MIT
"""Interrupts: response, wake-up, the instruction in between, and the statistics of handlers."""

import json
import unittest

from harness import Session, image

# Data sheet: response 4 cycles, 5 with a 22-bit program counter; RETI the same. The vector table
# jumps by RJMP (-mrelax): 2.
RESPONSE = {"uno": 4, "mega": 5}
RJMP = 2
FROM_SLEEP = 4


class Interrupts(unittest.TestCase):
    """images/interrupts.c"""

    def check(self, board):
        with Session(image(board, "interrupts")) as sim:
            self.assertEqual(sim.run(60_000), "ok 60000")
            results = sim.results(5)
            stats = json.loads(sim.ask("stats"))["boards"][0]
            self.assertEqual(sim.ask("mark"), "ok 60000")
            marked = json.loads(sim.ask("stats"))["boards"][0]
        # OCR1A = 100: the flag is set when TCNT becomes 101, at the end of a nop (or asleep). The
        # handler's lds reads in its second cycle.
        first_read = 101 + RESPONSE[board] + RJMP + 1
        self.assertEqual(results[0], first_read)
        self.assertEqual(results[1], first_read + FROM_SLEEP)
        # "The instruction following SEI will be executed before any pending interrupts", and so is
        # one instruction after RETI.
        self.assertEqual(results[2], 1)
        self.assertEqual(results[3], 2)
        self.assertEqual(results[4], 0x600D)
        handler = next(h for h in stats["handlers"] if h["name"] == "TIMER1_COMPB")
        cycles = RESPONSE[board] + RJMP + 10 + RESPONSE[board]
        self.assertEqual(handler["count"], 21)
        self.assertEqual((handler["cycles_min"], handler["cycles_max"]), (cycles, cycles))
        self.assertEqual(handler["cycles_sum"], 21 * cycles)
        # From the flag, or from the program that lets it in, to the response: at the end of a nop
        # or asleep at once. TOV1 waits for the handler of ICF1, which the STS that enables both and
        # SEI with its instruction hold up, and for one instruction behind its RETI.
        waited = {h["name"]: h["latency_max"] for h in stats["handlers"]}
        enabled = 3
        capture = RESPONSE[board] + RJMP + 1 + RESPONSE[board]
        self.assertEqual(waited["TIMER1_COMPA"], 0)
        self.assertEqual(waited["TIMER1_CAPT"], enabled)
        self.assertEqual(waited["TIMER1_OVF"], enabled + capture + 1)
        self.assertIn(waited["TIMER0_OVF"], range(90, 110))
        # 1000 nops and the out that ends the section; the handler served in it does not count.
        self.assertEqual(stats["sections"][3], 1001)
        self.assertEqual(stats["section_longest"][3], 1001)
        # Off for the 100 nops of eight_bits() at most; on for 1000 and more at a time.
        self.assertIn(stats["interrupts_off_max_cycles"], range(101, 160))
        self.assertGreaterEqual(
            stats["interrupts_off_max_cycles"], stats["interrupts_off_main_max_cycles"]
        )
        self.assertEqual(stats["section_entries"][3], 1)
        # A mark begins the handlers anew and leaves the sums that only grow.
        self.assertEqual(marked["handlers"], [])
        self.assertEqual(marked["interrupts_off_max_cycles"], 0)
        self.assertEqual(set(marked["section_longest"]), {0})
        self.assertEqual(marked["interrupt_cycles"], stats["interrupt_cycles"])

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


class BehindReti(unittest.TestCase):
    """images/nested.c: one instruction runs behind RETI, whatever I was before."""

    def check(self, board):
        with Session(image(board, "nested")) as sim:
            sim.run(40_000)
            *phases, end = sim.results(41)
        self.assertEqual(end, 0x600D)
        nested = [phase for phase in phases if phase & 0x100]
        behind = [phase for phase in phases if not phase & 0x100]
        self.assertGreater(len(nested), 5)
        self.assertEqual(set(nested), {0x100})
        # Matches in the cycles of RETI and in those of the instruction behind it.
        at_once = RESPONSE[board] + 1
        self.assertEqual(behind[:at_once], [1] * at_once)
        self.assertEqual(behind[at_once:], list(range(2, 2 + len(behind) - at_once)))

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


class Skips(unittest.TestCase):
    """images/skips.c: a skip over ADIW or SBIW passes one word, in two cycles."""

    def check(self, board):
        with Session(image(board, "skips")) as sim:
            sim.run(20_000)
            *cases, end = sim.results(41)
        self.assertEqual(end, 0x600D)
        self.assertEqual([f"{case:04x}" for case in cases], ["0202"] * 40)

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


if __name__ == "__main__":
    unittest.main()
