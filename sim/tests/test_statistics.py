# SPDX-License-Identifier: MIT
"""What the simulator says of interrupts and sections, beside a reckoning from the data sheets."""

import json
import unittest

from harness import Session, image

RESPONSE = {"uno": 4, "mega": 5}  # and RETI
RJMP = 2
# images/sections.c: each section written to GPIOR1, and the nops behind that.
STAYS = (
    (4, 100), (1, 30), (7, 50), (5, 70), (2, 20), (7, 10), (0, 40), (3, 15), (1, 25), (7, 5),
    (4, 200), (5, 60), (9, 33), (4, 90), (1, 31), (7, 3), (1, 29), (0, 1), (2, 12), (7, 7),
    (4, 0), (6, 45), (1, 8), (7, 4), (0, 0),
)  # fmt: skip
BACK, LAST, CALLED = 7, 6, (1, 2, 3)
VECTORS = {
    "uno": {
        1: "INT0", 2: "INT1", 6: "WDT", 7: "TIMER2_COMPA", 8: "TIMER2_COMPB", 9: "TIMER2_OVF",
        11: "TIMER1_COMPA", 12: "TIMER1_COMPB", 13: "TIMER1_OVF", 14: "TIMER0_COMPA",
        15: "TIMER0_COMPB", 16: "TIMER0_OVF", 17: "VECTOR_17", 19: "USART0_UDRE", 20: "USART0_TX",
        22: "EE_READY",
    },
    "mega": {
        **{1 + number: f"INT{number}" for number in range(8)},
        12: "WDT", 13: "TIMER2_COMPA", 14: "TIMER2_COMPB", 15: "TIMER2_OVF", 17: "TIMER1_COMPA",
        18: "TIMER1_COMPB", 19: "TIMER1_COMPC", 20: "TIMER1_OVF", 21: "TIMER0_COMPA",
        22: "TIMER0_COMPB", 23: "TIMER0_OVF", 24: "VECTOR_24", 26: "USART0_UDRE", 27: "USART0_TX",
        30: "EE_READY",
        32: "TIMER3_COMPA", 33: "TIMER3_COMPB", 34: "TIMER3_COMPC", 35: "TIMER3_OVF",
        42: "TIMER4_COMPA", 43: "TIMER4_COMPB", 44: "TIMER4_COMPC", 45: "TIMER4_OVF",
        47: "TIMER5_COMPA", 48: "TIMER5_COMPB", 49: "TIMER5_COMPC", 50: "TIMER5_OVF",
    },
}  # fmt: skip


def statistics(sim):
    return json.loads(sim.ask("stats"))["boards"][0]


def reckoned():
    """Cycles, entries and longest stay of each section but 0, which goes on behind the list."""
    cycles, entries, longest = [0] * 7, [0] * 7, [0] * 7
    stays = []  # of sections entered: section and cycles, with those of the sections called
    calling = None
    for section, nops in STAYS:
        if section == BACK:
            present = calling
        else:
            present = [min(section, LAST), 0]
            stays.append(present)
            entries[present[0]] += 1
            calling = calling if present[0] in CALLED else present
        cycles[present[0]] += nops + 1
        present[1] += nops + 1
        if present is not calling:
            calling[1] += nops + 1
    for number, stayed in stays:
        longest[number] = max(longest[number], stayed)
    return cycles, entries, longest


class Sections(unittest.TestCase):
    """images/sections.c"""

    def check(self, board):
        with Session(image(board, "sections")) as sim:
            sim.run(20_000)
            self.assertEqual(sim.results(1), [0x600D])
            stats = statistics(sim)
        cycles, entries, longest = reckoned()
        self.assertEqual(stats["sections"][1:], cycles[1:])
        self.assertEqual(stats["section_entries"], entries)
        self.assertEqual(stats["section_longest"][1:], longest[1:])
        handler = RESPONSE[board] + RJMP + 10 + RESPONSE[board]
        self.assertEqual(stats["interrupt_cycles"], handler)
        # The run ends with an instruction.
        self.assertIn(sum(stats["sections"]) + handler, (20_000, 20_001))

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


class Nested(unittest.TestCase):
    """images/nested.c: each handler's own cycles, whether another one came inside or behind."""

    def check(self, board):
        with Session(image(board, "nested")) as sim:
            sim.run(40_000)
            stats = statistics(sim)
        found = {one["name"]: one for one in stats["handlers"]}
        around = 2 * RESPONSE[board] + RJMP
        total = 0
        for name, own in (("TIMER1_COMPB", 1 + 1 + 20), ("TIMER1_COMPA", 1 + 1)):
            one = found.pop(name)
            cycles = around + own
            self.assertEqual((one["count"], one["cycles_sum"]), (40, 40 * cycles))
            self.assertEqual((one["cycles_min"], one["cycles_max"]), (cycles, cycles))
            self.assertEqual(one["cycles_mean"], cycles)
            total += 40 * cycles
        self.assertEqual(found, {})
        self.assertEqual(stats["interrupt_cycles"], total)

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


class Names(unittest.TestCase):
    """images/vectors.c: vectors by the data sheets' numbers."""

    def check(self, board):
        with Session(image(board, "vectors")) as sim:
            sim.run(400_000)
            self.assertEqual(sim.results(1), [0x600D])
            stats = statistics(sim)
        found = {one["vector"]: one["name"] for one in stats["handlers"]}
        self.assertEqual(found, VECTORS[board])

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


class LateMasks(unittest.TestCase):
    """images/late_masks.c: flags wait for their masks, and then for the end of one instruction.

    Not of timers 0 and 2, which are libsimavr's own, nor of TXC, whose wait begins with its flag.
    """

    def check(self, board):
        with Session(image(board, "late_masks")) as sim:
            sim.run(400_000)
            self.assertEqual(sim.results(1), [0x600D])
            stats = statistics(sim)
        waited = {one["name"]: (one["count"], one["latency_max"]) for one in stats["handlers"]}
        self.assertEqual(waited.pop("USART0_TX")[0], 1)
        names = ("INT0", "INT1", "TIMER1_COMPA", "TIMER1_COMPB", "TIMER1_OVF", "WDT")
        self.assertEqual(waited, dict.fromkeys(names, (1, 0)))

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


if __name__ == "__main__":
    unittest.main()
