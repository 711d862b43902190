# SPDX-License-Identifier: MIT
"""The 16-bit timer model against numbers reckoned by hand from the data sheet."""

import unittest

from harness import (
    GPIOR2,
    Session,
    SimTest,
    differences,
    falling,
    image,
    read_edges,
    rising,
)

BOARDS = ("uno", "mega")
AXIS_OF_CAPTURE = {"uno": 0, "mega": 3}
CAPTURE_PIN = {"uno": "B 0", "mega": "L 1"}
ICP1 = {"uno": "B 0", "mega": "D 4"}
RESPONSE = {"uno": 4, "mega": 5}

OCF1C, OCF1B, OCF1A, TOV1 = 8, 4, 2, 1


class Intervals(SimTest):
    """images/intervals.c: 400, 401, ... ticks, then quiet, then OCR1B = TOP, then 600."""

    def check(self, board):
        edges = self.run_edges(image(board, "intervals"), 160_000)
        up, down = rising(edges), falling(edges)
        # The compare values of before mode 15 make the first period; the handler served at its end
        # loads the one after next: 400 twice, then one more tick each.
        self.assertEqual(differences(up)[:100], [400, *range(400, 499)])
        # A pulse lasts from 32 cycles after BOTTOM to the next BOTTOM.
        lengths = [b - a for a, b in zip(up, down, strict=False)]
        self.assertEqual(lengths[:100], [t - 32 for t in [400, *range(400, 499)]])
        # Quiet: the last period of 499 ticks, then 8 of 1000 and 8 of 800 without any edge.
        self.assertEqual(differences(up)[100], 499 + 8 * 1000 + 8 * 800)
        self.assertEqual(set(differences(up)[101:]), {600})

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


class CountWrites(unittest.TestCase):
    """images/count_writes.c: TCNT1 has what is written from the cycle behind the write on."""

    def check(self, board):
        with Session(image(board, "count_writes")) as sim:
            sim.run(5000)
            *counts, end = sim.results(7)
        self.assertEqual(end, 0x600D)
        written = ((0x1234, 0), (0x1234, 1), (0x1234, 2), (0x1234, 3), (0xFFFE, 10), (0x12FE, 10))
        # LDS reads two cycles behind the write, in its second one.
        self.assertEqual(counts, [(count + nops + 1) & 0xFFFF for count, nops in written])

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


# By number of experiment.
REGISTERS = {
    0: 0x0034,  # reading TCNT1L (TCNT1 = 0) has put 0 in TEMP's place of 0x12
    1: 0x5678,  # reading OCR1A has left TEMP alone
    2: 1,  # sts: in force at a + 1; lds begins there and reads at a + 2, TCNT = 1
    3: 2,
    4: 0,  # in at a + 1 + 99: TCNT = 99 = TOP, the flag comes with the step to 0
    5: TOV1,
    6: 0x1234,
    # The sts begins 97 cycles after a + 1 and writes at TCNT = 98, in force at 99: loaded at
    # BOTTOM. It ends at TCNT = 99; 149 nops on, the lds begins at 248 - 100 and reads one later.
    7: 149,
    # One later it is in force only in the step to BOTTOM itself: a second period of 100 ticks, at
    # whose end 200 is loaded. 98 + 2 + 149 + 1 = 250 cycles in all, less 2 periods.
    8: 50,
    9: TOV1 | OCF1A,
    10: TOV1,
    11: 0,
    12: OCF1B,
    13: 0,
    14: OCF1B,
    15: 0,
    # Counting from a + 1 through 48 nops and the sts that stops it (in force two cycles later):
    # 50. Then 9 nops and the lds's second cycle: 10 more.
    16: 60,
    17: 0x600D,
    # 16 counts to 0, 20 nops and the lds's second cycle.
    18: 5,
    19: 0,
    20: TOV1,
    21: 0,  # lds begins at TCNT = 99 = TOP and reads in the cycle of 0
}


class Registers(unittest.TestCase):
    """images/registers.c, experiment by experiment."""

    def check(self, board):
        with Session(image(board, "registers")) as sim:
            self.assertEqual(sim.run(20_000), "ok 20000")
            results = sim.results(22)
        self.assertEqual(dict(enumerate(results)), REGISTERS)

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


class Capture(SimTest):
    """images/capture.c: what ICRn holds is the count three cycles after the edge."""

    def check(self, board, hz, count):
        clock_log = self.folder / "clock.csv"
        options = [
            "--pixel-hz",
            hz,
            "--clock-log",
            str(clock_log),
            "--pixel-start-ms",
            "10",
        ]
        edges_path = self.folder / "edges.csv"
        options += ["--edges", str(edges_path), "--pixel-jitter-ns", "2000"]
        with Session(image(board, "capture"), options=options) as sim:
            sim.run(16_000_000)
            results = sim.results(1 + count)
        self.assertGreaterEqual(results[0], count)
        bottom = rising(read_edges(edges_path), axis=AXIS_OF_CAPTURE[board])[0] - 32
        clock = [int(row.split(",")[0]) for row in clock_log.read_text().split()[1:]]
        expected = [(edge + 3 - bottom) % 10_000 for edge in clock[:count]]
        self.assertEqual(results[1:], expected)

    def test_uno(self):
        self.check("uno", "997/10", 60)

    def test_mega(self):
        self.check("mega", "997/10", 60)


class Blocked(unittest.TestCase):
    """images/blocked.c: a write to TCNT blocks the match of the next clock, even at rest.

    A flag that is cleared in the step before the one that sets it is set.
    """

    def check(self, board):
        with Session(image(board, "blocked")) as sim:
            sim.run(5_000)
            self.assertEqual(sim.results(7), [0, OCF1B, OCF1B, 0, OCF1B, 0, 0x600D])

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


class CaptureAtBottom(SimTest):
    """images/capture.c: the count goes from TOP to 0; no capture reads TOP + 1."""

    PERIOD = 10_000
    EDGES = 40  # one count later each, around BOTTOM

    def check(self, board):
        edges = self.run_edges(image(board, "capture"), 100_000)
        bottom = (rising(edges, axis=AXIS_OF_CAPTURE[board])[0] - 32) % self.PERIOD
        first = 16 * self.PERIOD + bottom - 3 - self.EDGES // 2
        options = ["--pixel-hz", f"16000000/{2 * self.PERIOD + 1}"]
        options += ["--pixel-start-ms", f"{first / 16_000:.9f}"]
        with Session(image(board, "capture"), options=options) as sim:
            sim.run(2 * self.PERIOD * (self.EDGES + 12))
            results = sim.results(1 + self.EDGES)
        wanted = [(n - self.EDGES // 2) % self.PERIOD for n in range(self.EDGES)]
        self.assertEqual(results[1:], wanted)

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


class ChannelC(unittest.TestCase):
    """images/channel_c.c, by number of experiment."""

    WANTED = (
        0,  # OCR1C = 20: at TCNT = 20 the flag is not up yet
        OCF1C,
        0,  # 30, written at TCNT = 11, does not count in this period: TCNT = 60
        OCF1C,  # the 90 of before does: TCNT = 92
        0,  # cleared at 94; in the next period 30 counts, whose flag is not up at TCNT = 30
        OCF1C,
        0x1234,
        0x600D,
    )

    def test_mega(self):
        with Session(image("mega", "channel_c")) as sim:
            sim.run(5_000)
            self.assertEqual(tuple(sim.results(8)), self.WANTED)


class TwoEdges(SimTest):
    """images/capture.c: a second edge while the first one passes the synchroniser."""

    def check(self, board):
        path = self.folder / "edges.csv"
        with Session(image(board, "capture"), options=["--edges", str(path)]) as sim:
            for n, gap in enumerate((2, 3, 4)):
                at = 20_000 + 10_000 * n
                for cycle, level in ((at, 1), (at + 1, 0), (at + gap, 1), (at + gap + 1, 0)):
                    sim.ask(f"pin 0 {CAPTURE_PIN[board]} {level} at {cycle}")
            sim.run(60_000)
            results = sim.results(7)
            sim.ask("flush")
        bottom = rising(read_edges(path), axis=AXIS_OF_CAPTURE[board])[0] - 32
        # Each sets the flag, also while the first is being answered; the handler reads ICRn later
        # than both, the count of the second one.
        wanted = [(20_000 + gap + 3 - bottom) % 10_000 for gap in (2, 2, 3, 3, 4, 4)]
        self.assertEqual(results[1:], wanted)
        self.assertEqual(results[0], len(wanted))

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


class Instants(SimTest):
    """images/instants.c: writes and reads in the very cycle of what they meet."""

    (
        CONNECT_IN_TIME,
        CONNECT_LATE,
        DISCONNECT,
        READ_CAPTURE,
        TSM_ALONE,
        COMPARE,
        CLEARED,
        CANCELER,
    ) = range(8)
    ICP_SYNC = 3

    def edges_of(self, board, what, before=()):
        path = self.folder / "edges.csv"
        with Session(image(board, "instants"), options=["--edges", str(path)]) as sim:
            sim.ask(f"poke 0 {GPIOR2} {what:02x}")
            for command in before:
                self.assertTrue(sim.ask(command).startswith("ok"), command)
            sim.run(40_000)
            results = sim.results(2)
            sim.ask("flush")
        return read_edges(path), results

    def check_connection(self, board):
        """In force with TCNT = OCR1B the match drives the pin; one later not before the next."""
        # Behind the port's pulse CBI and STS, two cycles each, and the match's effect at TCNT = 51.
        for what, ticks in ((self.CONNECT_IN_TIME, 4 + 51), (self.CONNECT_LATE, 4 + 1000 + 51)):
            port, match = rising(self.edges_of(board, what)[0])[:2]
            self.assertEqual(match - port, ticks)
        edges, _ = self.edges_of(board, self.DISCONNECT)
        # The pin is the port's again, low, with TCNT = 60.
        self.assertEqual(differences([rising(edges)[0], *falling(edges)]), [60 - 51])

    def check_capture(self, board):
        """A read in the cycle in which ICR1 changes sees the change."""
        edges, _ = self.edges_of(board, self.READ_CAPTURE)
        # SBI's write is in force at the edge; 39 nops, and the second cycle of LDS reads.
        read = rising(edges)[0] + 39 + 1
        for late, seen in ((0, True), (1, False)):
            at = read - self.ICP_SYNC + late
            pin = f"pin 0 {ICP1[board]} 1 at {at}"
            _, results = self.edges_of(board, self.READ_CAPTURE, [pin])
            self.assertEqual((results[0] != 0, results[1]), (seen, 0x600D), late)

    def check_hold(self, board):
        """TSM holds what PSRSYNC resets; alone it holds nothing."""
        _, results = self.edges_of(board, self.TSM_ALONE)
        self.assertEqual(results[0], 1)

    def check_compare(self, board):
        """The handler of a match whose value was written on the way reads its count in time."""
        _, results = self.edges_of(board, self.COMPARE)
        # The flag comes with TCNT = 51; then the response, RJMP or JMP, LDS's second cycle.
        self.assertIn(results[0] - 51 - RESPONSE[board] - 1, (2, 3))
        self.assertEqual(results[1], 0x600D)

    def check_clearing(self, board):
        """The request goes with its flag."""
        _, results = self.edges_of(board, self.CLEARED)
        self.assertEqual(results, [0, OCF1B])

    def check_canceler(self, board):
        """A level that is there for four cycles is captured, one of three is noise."""
        with Session(image(board, "instants")) as sim:
            sim.ask(f"poke 0 {GPIOR2} {self.CANCELER:02x}")
            sim.run(10_000)
            for number, (width, captured) in enumerate(((3, 0), (4, 1), (5, 2), (3, 2))):
                at = 20_000 + 10_000 * number
                for cycle, level in ((at, 1), (at + width, 0)):
                    sim.ask(f"pin 0 {ICP1[board]} {level} at {cycle}")
                sim.run(12_000 if number == 0 else 10_000)
                self.assertEqual(sim.results(1), [captured], width)

    def check(self, board):
        self.check_connection(board)
        self.check_capture(board)
        self.check_hold(board)
        self.check_compare(board)
        self.check_clearing(board)
        self.check_canceler(board)

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


class Together(SimTest):
    """images/together.c: GTCCR starts, holds and releases all timers at one instant."""

    def check(self, board, axes):
        edges = self.run_edges(image(board, "together"), 200_000)
        first = rising(edges, axis=0)
        self.assertGreater(len(first), 100)
        gaps = differences(first)
        # 40 periods of 1000, one made longer by the hold, and 1000 again.
        self.assertEqual(set(gaps[:39]), {1000})
        self.assertEqual(len([gap for gap in gaps if gap != 1000]), 1)
        for axis in range(1, axes):
            self.assertEqual(rising(edges, axis=axis), first)
            self.assertEqual(falling(edges, axis=axis), falling(edges, axis=0))

    def test_uno(self):
        self.check("uno", 1)

    def test_mega(self):
        self.check("mega", 4)


REFUSALS = {
    1: "timer 1: waveform mode 14 is not modelled",
    2: "timer 1: clock select 2 is not modelled",
    3: "timer 1: COM1B = 1 in waveform mode 15 is not modelled",
    4: "timer 1: OCR1A is 2 at BOTTOM",
    5: "timer 1: force compare is not modelled",
    6: "UART 0: synchronous modes are not modelled",
    7: "timer 1: TCNT written to TOP or above while counting",
    8: "timer 1: OCR1A is 0 at BOTTOM",
    9: "timer 1: TCNT written to TOP or above while counting",
}


class Refused(unittest.TestCase):
    """images/refused.c: what is not modelled stops the run with its name."""

    def test_each(self):
        for case, text in REFUSALS.items():
            with self.subTest(case=case), Session(image("uno", "refused")) as sim:
                self.assertEqual(sim.ask(f"poke 0 {GPIOR2} {case:02x}"), "ok")
                answer = sim.run(10_000)
                self.assertTrue(answer.startswith(f"error board 0 (uno): {text}"), answer)
                # It has stopped for good.
                self.assertTrue(sim.run(1).startswith("error "))


if __name__ == "__main__":
    unittest.main()
