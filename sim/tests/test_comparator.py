# SPDX-License-Identifier: MIT
"""The analog comparator as timer 1's capture source, against numbers reckoned by hand."""

import itertools
import unittest

from harness import GPIOR2, RESULT_ADDRESS, Session, SimTest, image, read_edges, rising

BOARDS = ("uno", "mega", "m1284")
TOP_TICKS = 9999
CYCLES = 420_000  # of images/aco.c: its watchdog resets after 16 ms, 320,000 cycles at 20 MHz

# Port and bit of each ADC channel that has a digital pin.
CHANNELS = {
    "uno": [("C", bit) for bit in range(6)],
    "mega": [("F", bit) for bit in range(8)] + [("K", bit) for bit in range(8)],
    "m1284": [("A", bit) for bit in range(8)],
}
ICP1 = {"uno": ("B", 0), "mega": ("D", 4), "m1284": ("D", 6)}

# images/comparator.c
DO_RISING, DO_CANCELER, DO_PIN, DO_PULL_UP = 1, 2, 4, 8
FIRST_CHANNEL = RESULT_ADDRESS + 2 * 62
CHANNEL = RESULT_ADDRESS + 2 * 63

ACBG, ACO, ACI, ACIC, ACIS1, ACIS0 = 0x40, 0x20, 0x10, 0x04, 0x02, 0x01
NOTHING = 0xFFFF

# By number of experiment of images/aco.c.
ACO_RESULTS = {
    # The pin is low from the cycle after cbi: `in` reads in that cycle, and one, two, three later.
    0: ACBG,
    1: ACBG,
    2: ACBG | ACO | ACI,
    3: ACBG | ACO | ACI,
    4: ACBG | ACO | ACI,  # ACIS = 0: either change
    5: ACBG | ACI,
    6: ACBG | ACIS1 | ACO,  # 2: the output falls
    7: ACBG | ACIS1 | ACI,
    8: ACBG | ACIS1 | ACIS0 | ACO | ACI,  # 3: it rises
    9: ACBG | ACIS1 | ACIS0,
    # TCNT1 = 0 in cbi's first cycle, 2 when the pin is low, 5 three later.
    10: 5,
    11: NOTHING,  # the output rises: no falling edge
    12: NOTHING,  # ACIC = 0
    13: 9,  # the noise canceler: four more
    14: NOTHING,  # low for two cycles: not four equal samples
    15: 9,  # low for four
    16: 0,
    17: 0x20,  # ICF1 with the third cycle after the edge
    # sts writes with TCNT1 = 1, in force at 2.
    18: 5,
    # out writes with TCNT1 = 0, in force at 1.
    19: 4,
    20: 4,
    21: NOTHING,  # the source stays: no edge
    22: 0,  # a reset leaves neither the output nor its flag
    23: 0x600D,
}


class Registers(unittest.TestCase):
    """images/aco.c, experiment by experiment."""

    def check(self, board):
        with Session(image(board, "aco")) as sim:
            self.assertEqual(sim.run(CYCLES), f"ok {CYCLES}")
            results = sim.results(len(ACO_RESULTS))
        self.assertEqual(dict(enumerate(results)), ACO_RESULTS)

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")

    def test_m1284(self):
        self.check("m1284")


class Capture(SimTest):
    """images/comparator.c: edges driven from outside, captured three cycles later."""

    def start(self, board, what, channel=0):
        self.edges_path = self.folder / "edges.csv"
        sim = Session(
            image(board, "comparator"),
            options=["--edges", str(self.edges_path), "--pixel-hz", "1000"],
        )
        self.addCleanup(sim.__exit__)
        self.sim = sim
        self.tell(f"poke 0 {GPIOR2} {what:02x}")
        self.tell(f"poke 0 {FIRST_CHANNEL} {channel:02x}00")
        return sim

    def tell(self, command):
        answer = self.sim.ask(command)
        self.assertTrue(answer.startswith("ok"), f"{command}: {answer}")
        return answer

    def run_on(self, cycles):
        """The cycle at which the run ends."""
        return int(self.tell(f"run {cycles}").split()[1])

    def drive(self, pin, level):
        self.tell(f"pin 0 {pin[0]} {pin[1]} {level}")

    def captured(self):
        count = self.sim.results(1)[0]
        return self.sim.results(1 + count)[1:]

    def bottom(self):
        """A cycle in which TCNT1 was 0."""
        self.tell("flush")
        return rising(read_edges(self.edges_path))[0] - 32

    def counts_at(self, cycles, delay):
        bottom = self.bottom()
        return [(cycle + delay - bottom) % (TOP_TICKS + 1) for cycle in cycles]

    def toggle(self, pin, first_level, times, first_cycles=20_000):
        """Drive a pin to and fro; return the cycles of the changes to 0, and to 1."""
        cycles = ([], [])
        level = first_level
        now = self.run_on(first_cycles)
        for number in range(times):
            self.drive(pin, level)
            cycles[level].append(now)
            level = 1 - level
            now = self.run_on(1_001 + 37 * number)
        return cycles

    def check_edges(self, board, what, delay):
        self.start(board, what | DO_PULL_UP)
        falls, rises = self.toggle(CHANNELS[board][0], 0, 30)
        expected = falls if what & DO_RISING else rises
        self.assertEqual(len(expected), 15)
        self.assertEqual(self.captured(), self.counts_at(expected, delay))

    def test_pin_falls(self):
        for board in BOARDS:
            with self.subTest(board=board):
                self.check_edges(board, DO_RISING, 3)

    def test_pin_rises(self):
        for board in BOARDS:
            with self.subTest(board=board):
                self.check_edges(board, 0, 3)

    def test_noise_canceler(self):
        for board in BOARDS:
            with self.subTest(board=board):
                self.check_edges(board, DO_RISING | DO_CANCELER, 7)

    def drive_at(self, pin, cycles):
        """Drive a high pin low at the first cycle, and to and fro at the others; run past them."""
        for number, cycle in enumerate(cycles):
            self.tell(f"pin 0 {pin[0]} {pin[1]} {number % 2} at {cycle}")
        self.run_on(5_000)

    def bounced(self, board, apart):
        """Captures of a fall and of another one so many cycles behind: 1 the first, 2 the other."""
        self.start(board, DO_RISING | DO_PULL_UP)
        first = self.run_on(20_000) + 1_000
        self.drive_at(CHANNELS[board][0], (first, first + apart // 2, first + apart))
        counts = self.counts_at((first, first + apart), 3)
        return [1 + counts.index(count) for count in self.captured()]

    def test_a_bounce_overwrites_what_was_not_read(self):
        """Each event updates ICR1, also one that comes before it was read.

        An edge behind the one that interrupts is all that the handler reads, unless it comes behind
        the reading; its own flag interrupts once more.
        """
        for board in BOARDS:
            with self.subTest(board=board):
                found = {apart: self.bounced(board, apart) for apart in range(2, 90, 2)}
                kinds = [kind for kind, _ in itertools.groupby(found.values())]
                self.assertEqual(kinds, [[2, 2], [1, 2]])
                # Its reading lies behind 4 cycles of entry, a jump and the saving of registers.
                self.assertTrue(16 < [*found.values()].index([1, 2]) * 2 + 2 < 60, found)

    def test_a_level_that_changes_every_cycle(self):
        """Each second cycle has an edge; the first ones do not wait for the last."""
        for board in BOARDS:
            with self.subTest(board=board):
                self.start(board, DO_RISING | DO_PULL_UP)
                first = self.run_on(20_000) + 1_000
                cycles = range(first, first + 201)
                self.drive_at(CHANNELS[board][0], cycles)
                found = self.captured()
                falls = self.counts_at(cycles[::2], 3)
                self.assertLess(falls.index(found[0]), 30)
                self.assertGreater(len(found), 3)
                self.assertEqual(found, [count for count in falls if count in found])
                self.assertEqual(found[-1], falls[-1])

    def test_every_channel_hears_its_own_pin_only(self):
        for board in BOARDS:
            for channel, own in enumerate(CHANNELS[board]):
                with self.subTest(board=board, channel=channel):
                    self.start(board, DO_RISING | DO_PULL_UP, channel)
                    now = self.run_on(20_000)
                    for pin in CHANNELS[board]:
                        if pin != own:
                            self.drive(pin, 0)
                            now = self.run_on(500)
                    self.assertEqual(self.captured(), [])
                    self.drive(own, 0)
                    self.run_on(500)
                    self.assertEqual(self.captured(), self.counts_at([now], 3))

    def test_change_of_channel(self):
        """To a low pin: an edge. To a high one: none."""
        for board in BOARDS:
            with self.subTest(board=board):
                self.start(board, DO_RISING | DO_PULL_UP)
                low = CHANNELS[board][3]
                self.run_on(20_000)
                self.drive(low, 0)
                self.run_on(1_000)
                self.tell(f"poke 0 {CHANNEL} 0100")
                self.run_on(1_000)
                self.assertEqual(self.captured(), [])
                self.tell(f"poke 0 {CHANNEL} 0300")
                now = self.run_on(1_000)
                count, since = self.captured(), self.bottom()
                self.assertEqual(len(count), 1)
                behind = (now - since - count[0]) % (TOP_TICKS + 1)
                self.assertTrue(900 < behind < 1_000, behind)

    def test_pin_of_the_timer_is_cut_off(self):
        """While the comparator captures, ICP1 does not; without ACIC only ICP1 does."""
        for board in BOARDS:
            with self.subTest(board=board):
                self.start(board, DO_RISING | DO_PULL_UP)
                self.toggle(ICP1[board], 1, 6)
                self.assertEqual(self.captured(), [])
                self.start(board, DO_RISING | DO_PULL_UP | DO_PIN)
                # The Uno's ICP1 is the pixel clock's pin: keep that quiet.
                self.tell("clock off")
                _, rises = self.toggle(ICP1[board], 1, 6)
                self.toggle(CHANNELS[board][0], 0, 6, first_cycles=1_000)
                self.assertEqual(self.captured(), self.counts_at(rises, 3))

    def test_other_timers_go_on(self):
        """The Mega's pixel clock is captured by timer 5."""
        self.start("mega", DO_RISING | DO_PULL_UP)
        self.run_on(200_000)
        self.assertEqual(self.captured(), [])
        tifr5 = int(self.sim.ask("peek 0 0x3a 1").split()[1], 16)
        self.assertEqual(tifr5 & 0x20, 0x20)  # its ICF5 waits; TCCR5B = 0 captures all the same

    def test_no_pull_up_is_low(self):
        self.start("uno", DO_RISING)
        self.run_on(20_000)
        self.drive(CHANNELS["uno"][0], 0)
        self.run_on(1_000)
        self.assertEqual(self.captured(), [])  # it was low: no edge


REFUSALS = {
    20: "its interrupt (ACIE = 1) is not modelled",
    21: "with ACIC = 1, AIN0 as positive input (ACBG = 0) is not modelled",
    22: "with ACIC = 1, AIN1 as negative input (ADEN = 1) is not modelled",
    23: "with ACIC = 1, AIN1 as negative input (ACME = 0) is not modelled",
    24: "with ACIC = 1, it is switched off (ACD = 1)",
    25: "with ACIC = 1, ADC6 and ADC7 have no digital pin",
    26: "with ACIC = 1, MUX4:3 other than 0 are not modelled",
    27: "with ACIC = 1, the multiplexer has no power (PRADC = 1)",
    28: "ACIS1:0 = 1 is reserved",
}
MODELLED = 99


class Refused(unittest.TestCase):
    """images/refused.c: what is not modelled stops the run with its name."""

    def ask(self, case):
        with Session(image("uno", "refused")) as sim:
            self.assertEqual(sim.ask(f"poke 0 {GPIOR2} {case:02x}"), "ok")
            return sim.run(10_000)

    def test_each(self):
        for case, text in REFUSALS.items():
            with self.subTest(case=case):
                answer = self.ask(case)
                prefix = f"error board 0 (uno): analog comparator: {text}, at cycle "
                self.assertTrue(answer.startswith(prefix), answer)

    def test_what_is_modelled_is_not(self):
        self.assertEqual(self.ask(MODELLED), "ok 10000")


if __name__ == "__main__":
    unittest.main()
