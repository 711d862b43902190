# SPDX-License-Identifier: MIT
"""The pixel clock's gate, rests and jitter; flaws of one board's pin; supplies that come apart."""

import csv
import itertools
import unittest

from harness import Session, SimTest, call, image

PERIOD = 160_000  # at 100 Hz
FIRST = 160_000  # the clock's first edge, 10 ms behind the start
TOP_TICKS = 10_000  # images/capture.c


def edges_of(k):
    return FIRST + k * PERIOD


class PinTest(SimTest):
    """Runs commands on two boards and reads which edges reached each pin."""

    def pins(self, commands, *options, boards=("uno", "mega")):
        log = self.folder / "pins.csv"
        options = ["--pin-log", str(log), "--pixel-hz", "100", *options]
        with Session(*(image(name, "capture") for name in boards), options=options) as sim:
            for command in commands:
                self.assertTrue(sim.ask(command).startswith("ok"), command)
            self.captured = [sim.results(60, board) for board in range(len(boards))]
            sim.ask("flush")
            with log.open(newline="") as file:
                rows = [(int(r["cycle"]), int(r["board"]), r["edge"]) for r in csv.DictReader(file)]
        return [[(c, e) for c, b, e in rows if b == board] for board in range(len(boards))]

    def check_captured(self, board, pins):
        """The board's own timer has captured exactly the edges of the log, each in its cycle."""
        count, *ticks = self.captured[board]
        self.assertEqual(count, len(pins[board]))
        seen = [(tick & 0x3FFF) for tick in ticks[:count]]
        off = {
            (tick - cycle) % TOP_TICKS for tick, (cycle, _) in zip(seen, pins[board], strict=False)
        }
        self.assertEqual(len(off), 1, (seen, pins[board]))


class Clock(PinTest):
    def test_a_gate_lets_edges_pass_and_rests(self):
        pins = self.pins(["run 3190000"], "--pixel-gate", "3,12.5")
        burst = 3 * PERIOD + 200_000
        wanted = [FIRST + b * burst + k * PERIOD for b in range(6) for k in range(3)]
        wanted = [cycle for cycle in wanted if cycle < 3_200_000]
        for board in range(2):
            self.assertEqual(pins[board], [(cycle, "true") for cycle in wanted])
            self.check_captured(board, pins)

    def test_a_gate_by_command_counts_from_the_next_edge(self):
        commands = [f"run {edges_of(2) + 1000}", "clock gate 2 50000", "run 2400000"]
        pins = self.pins([*commands, "clock gate 0 0", "run 1600000"])
        cycles = [cycle for cycle, _ in pins[0]]
        gaps = [b - a for a, b in itertools.pairwise(cycles)]
        rest = PERIOD + 800_000
        self.assertEqual(gaps[:7], [PERIOD] * 4 + [rest, PERIOD, rest])
        self.assertEqual(set(gaps[7:]), {PERIOD})

    def test_a_rest_shifts_the_time_line(self):
        pins = self.pins([f"run {edges_of(3) - 1000}", "clock rest 7001", "run 800000"])
        shift = 7001 * 16
        wanted = [edges_of(k) + (shift if k >= 3 else 0) for k in range(8)]
        self.assertEqual([c for c, _ in pins[1]], [c for c in wanted if c < edges_of(8) - 1000])

    def test_off_and_on_keep_the_time_line(self):
        pins = self.pins([f"run {edges_of(2)}", "run 100", "clock off", "run 500000", "clock on",
                          "run 300000"])  # fmt: skip
        self.assertEqual([c for c, _ in pins[0]], [edges_of(k) for k in (0, 1, 2, 6, 7)])

    def test_another_frequency_in_motion(self):
        pins = self.pins(["run 500000", "clock hz 400", "run 190000"])
        later = [500_000 + 40_000 * k for k in range(1, 5)]
        self.assertEqual([c for c, _ in pins[0]], [edges_of(0), edges_of(1), edges_of(2), *later])

    def test_jitter_by_command_is_that_of_the_option(self):
        commands = [f"run {edges_of(4) + 900}", "clock jitter 50000", "run 6400000"]
        pins = self.pins(commands)
        off = [cycle - edges_of(k) for k, (cycle, _) in enumerate(pins[0])]
        self.assertEqual(off[:5], [0] * 5)
        self.assertEqual(pins[0], pins[1])
        later = off[6:]  # one was made before
        self.assertTrue(all(abs(one) <= 800 for one in later) and len(set(later)) > 10, later)
        rms = self.pins([*commands[:1], "clock jitter-rms 50000", "run 6400000"])
        off = [cycle - edges_of(k) for k, (cycle, _) in enumerate(rms[0])]
        self.assertTrue(any(abs(one) > 800 for one in off[6:]))


class ClockLog(SimTest):
    """The clock's own edges, as the log has them: cycle, exact time, kind."""

    HZ = 100

    def rows(self, *options, commands=("run 3200000",), hz="100"):
        log = self.folder / "clock.csv"
        options = ["--clock-log", str(log), "--pixel-hz", hz, *options]
        with Session(image("uno", "echo"), options=options) as sim:
            for command in commands:
                self.assertTrue(sim.ask(command).startswith("ok"), command)
            sim.ask("flush")
            with log.open(newline="") as file:
                return [
                    (int(r["cycle"]), int(r["true_cycle_x1000"]), r["edge"])
                    for r in csv.DictReader(file)
                ]

    def check_periods(self, rows, periods):
        """Each edge in the cycle of its exact time, so many thousandths behind the one before."""
        for cycle, exact, kind in rows:
            self.assertEqual((cycle, kind), (exact // 1000, "true"))
        gaps = [b[1] - a[1] for a, b in itertools.pairwise(rows)]
        self.assertEqual(len(gaps), len(periods))
        for gap, period in zip(gaps, periods, strict=True):
            self.assertLessEqual(abs(gap - period), 1)

    def test_fractions_of_a_cycle_add_up(self):
        for hz, period in (("997/10", 160_481.444333), ("1000/3", 48_000)):
            rows = self.rows(hz=hz, commands=("run 8000000",))
            self.assertEqual(len(rows), int((8_000_000 + 64 - FIRST) // period) + 1)
            for k, (cycle, exact, _) in enumerate(rows):
                self.assertLessEqual(abs(exact - 1000 * (FIRST + k * period)), 2)
                self.assertEqual(cycle, exact // 1000)

    def test_a_clock_that_is_off(self):
        for ppm in (-900, 900, 2500.5):
            rows = self.rows("--pixel-ppm", str(ppm))
            period = PERIOD / (1 + ppm / 1e6)
            self.check_periods(rows, [round(1000 * period)] * (len(rows) - 1))

    def test_periods_of_whole_cycles_stay_so(self):
        """Far off in either direction, an edge that lies on a cycle is not in the one before."""
        for ppm, hz in (("-100000", "1000/9"), ("100000", "1000/11"), ("-50000", "2000/19")):
            rows = self.rows("--pixel-ppm", ppm, hz=hz)
            wanted = range(FIRST, rows[-1][0] + 1, PERIOD)
            self.assertGreater(len(wanted), 10)
            self.assertEqual(rows, [(cycle, 1000 * cycle, "true") for cycle in wanted])

    def test_a_step_at_the_first_edge(self):
        rows = self.rows("--pixel-step", "2000@1")
        later = round(1000 * PERIOD / 1.002)
        self.check_periods(rows, [1000 * PERIOD] + [later] * (len(rows) - 2))

    def test_a_step_of_the_frequency(self):
        rows = self.rows("--pixel-step", "2000@7")
        later = round(1000 * PERIOD / 1.002)
        self.check_periods(rows, [1000 * PERIOD] * 7 + [later] * (len(rows) - 8))

    def test_a_clock_that_wanders(self):
        """By a sine of a thousand edges: the mean is right, a quarter on it is off most."""
        rows = self.rows("--pixel-wander-ppm", "1000", hz="4000", commands=("run 4010000",))
        gaps = [(b[1] - a[1]) / 4_000_000 - 1 for a, b in itertools.pairwise(rows)]
        self.assertGreaterEqual(len(gaps), 900)
        self.assertLess(abs(gaps[0]), 2e-5)
        self.assertAlmostEqual(gaps[250], -1e-3, delta=1e-5)
        self.assertAlmostEqual(gaps[750], 1e-3, delta=1e-5)

    def test_missing_and_doubled_edges(self):
        rows = self.rows("--pixel-drop", "4")
        kinds = [kind for _, _, kind in rows]
        self.assertEqual(kinds[:8], ["true", "true", "true", "missing"] * 2)
        rows = self.rows("--pixel-double", "4")
        kinds = [kind for _, _, kind in rows]
        self.assertEqual(kinds[:10], ["true", "true", "true", "false", "true"] * 2)
        self.assertEqual([c for c, _, kind in rows if kind == "true"][:8],
                         [edges_of(k) for k in range(8)])  # fmt: skip

    def test_dropped_by_command(self):
        rows = self.rows(commands=("run 200000", "clock drop 2", "run 1000000"))
        self.assertEqual([kind for _, _, kind in rows][:5],
                         ["true", "missing", "missing", "true", "true"])  # fmt: skip

    def test_a_rest_moves_the_edge_that_is_made_and_those_behind_it(self):
        rest = 7001 * 16
        rows = self.rows(commands=(f"run {edges_of(3) - 1000}", "clock rest 7001", "run 800000"))
        periods = [1000 * PERIOD] * (len(rows) - 1)
        periods[2] += 1000 * rest
        self.check_periods(rows, periods)

    def test_another_rate_in_motion(self):
        commands = ("run 500000", "clock ppm 1000", "run 800000", "clock ppm 0", "run 800000")
        rows = self.rows(commands=commands)
        gaps = [b[1] - a[1] for a, b in itertools.pairwise(rows)]
        off = [gap for gap in gaps if gap != 1000 * PERIOD]
        self.assertEqual(len(off), 5)
        self.assertEqual(gaps[4:9], off)  # the edge behind the next one has its time already
        for gap in off:
            self.assertLessEqual(abs(gap - 1000 * PERIOD / 1.001), 1000)

    def test_a_pulse_is_a_quarter_of_the_period_and_50_us_at_most(self):
        path = self.folder / "waves.vcd"
        for hz, high in (("100", 800), ("4000", 800), ("8000", 501), ("16000", 251)):
            options = ["--pixel-hz", hz, "--vcd", str(path)]
            with Session(image("uno", "echo"), options=options) as sim:
                sim.run(400_000)
                sim.ask("flush")
            lines = path.read_text().splitlines()
            name = next(line.split()[3] for line in lines if "CLOCK" in line.upper())
            at, edges = 0, []
            for line in lines[lines.index("$end", lines.index("$dumpvars")) :]:
                at = int(line[1:]) // 625 if line.startswith("#") else at
                if line[1:] == name:
                    edges.append((at, line[0]))
            rises = [at for at, level in edges if level == "1"]
            falls = [at for at, level in edges if level == "0"]
            self.assertGreater(len(rises), 1)
            period = 16_000_000 // int(hz)
            self.assertEqual(rises, [FIRST + k * period for k in range(len(rises))])
            self.assertGreaterEqual(len(falls), len(rises) - 1)
            for rise, fall in zip(rises, falls, strict=False):
                self.assertEqual(fall - rise, high, hz)


class OnePin(PinTest):
    def test_a_missing_edge_at_one_pin(self):
        pins = self.pins(["run 200000", "edge 1 miss 2", "run 1000000"])
        self.assertEqual([c for c, _ in pins[0]], [edges_of(k) for k in range(7)])
        self.assertEqual([c for c, _ in pins[1]], [edges_of(k) for k in range(7) if k != 2])
        for board in range(2):
            self.check_captured(board, pins)

    def test_a_false_edge_at_one_pin(self):
        for phase in (1, 100, 500, 999):
            pins = self.pins(["run 200000", f"edge 0 add 3 {phase}", "run 1000000"])
            self.assertEqual(pins[1], [(edges_of(k), "true") for k in range(7)])
            false = [cycle for cycle, kind in pins[0] if kind == "false"]
            # Within the pulse of 50 us: right after it.
            wanted = max(edges_of(3) + phase * PERIOD // 1000, edges_of(3) + 802)
            self.assertEqual(false, [wanted], phase)
            self.assertEqual([c for c, kind in pins[0] if kind == "true"], [c for c, _ in pins[1]])
            self.check_captured(0, pins)

    def test_a_doubled_edge_lies_where_those_of_the_clock_do(self):
        phases = set()
        for seed in range(8):
            pins = self.pins(["edge 1 double 1", "run 400000"], "--seed", str(seed))
            (false,) = [cycle for cycle, kind in pins[1] if kind == "false"]
            self.assertTrue(0.05 <= (false - FIRST) / PERIOD <= 0.7)
            self.assertNotIn("false", [kind for _, kind in pins[0]])
            phases.add(false)
        self.assertGreater(len(phases), 5)

    def test_a_false_edge_at_a_cycle_also_while_the_clock_rests(self):
        commands = ["clock off", "edge 0 pulse at 300123", "edge 0 pulse at 300005", "run 400000"]
        pins = self.pins(commands)
        self.assertEqual(pins, [[(300_005, "false"), (300_123, "false")], []])
        self.check_captured(0, pins)

    def test_a_false_edge_at_a_pin_with_jitter(self):
        """The jitter is that of the clock's edges alone, whether the clock goes on or rests."""
        commands = ["edge 0 jitter 20000", "clock off", "edge 0 pulse at 300123", "run 400000"]
        pins = self.pins(commands)
        self.assertEqual(pins, [[(300_123, "false")], []])
        self.check_captured(0, pins)
        # Nor is there an edge to wait for where there is no clock.
        with Session(image("uno", "capture")) as sim:
            for command in ("edge 0 jitter 20000", "edge 0 pulse at 300123", "run 400000"):
                self.assertTrue(sim.ask(command).startswith("ok"), command)
            self.assertEqual(sim.results(1), [1])
        at = edges_of(2) + 40_000
        pins = self.pins(["edge 0 jitter 20000", f"edge 0 pulse at {at}", "run 600000"])
        self.assertEqual([row for row in pins[0] if row[1] == "false"], [(at, "false")])
        self.assertEqual(len(pins[0]), len(pins[1]) + 1)

    def test_an_edge_without_room_before_the_next_one_is_lost(self):
        pins = self.pins([f"edge 0 pulse at {edges_of(1) - 3}", "run 500000"])
        self.assertEqual(pins[0], pins[1])
        pins = self.pins([f"edge 0 pulse at {edges_of(1) - 40}", "run 500000"])
        self.assertEqual(pins[0][1], (edges_of(1) - 40, "false"))
        self.assertEqual([c for c, kind in pins[0] if kind == "true"], [c for c, _ in pins[1]])

    def test_jitter_of_one_pin(self):
        pins = self.pins(["edge 1 jitter 20000", "run 7990000"])
        self.assertEqual([c for c, _ in pins[0]], [edges_of(k) for k in range(49)])
        off = [cycle - edges_of(k) for k, (cycle, _) in enumerate(pins[1])]
        self.assertTrue(min(off) < -150 and max(off) > 150 and max(map(abs, off)) <= 320, off)
        self.check_captured(1, pins)

    def test_what_is_refused(self):
        with Session(image("uno", "echo"), options=["--pixel-hz", "100"]) as sim:
            for command in (
                "edge 1 miss 1", "edge 0 miss 0", "edge 0 miss", "edge 0 add 1 1000",
                "edge 0 add 1", "edge 0 jump 1", "edge 0 pulse at", "clock rest",
                "clock gate 3", "clock gate x 1", "clock jitter -1", "clock drop",
            ):  # fmt: skip
                self.assertTrue(sim.ask(command).startswith("error "), command)
            for _ in range(32):
                self.assertEqual(sim.ask("edge 0 miss 9"), "ok")
            self.assertTrue(sim.ask("edge 0 miss 9").startswith("error "))
        for gate in ("3", "0,5", "x,5", "3,-1"):
            done = call("--board", image("uno", "echo"), "--run-ms", "1", "--pixel-gate", gate)
            self.assertEqual(done.returncode, 2, gate)


class PowerUp(SimTest):
    """images/capture.c makes a STEP edge every 10,000 cycles from where its program begins."""

    def starts(self, *options):
        path = self.folder / "edges.csv"
        boards = [image(name, "capture") for name in ("uno", "mega", "uno")]
        with Session(*boards, options=["--edges", str(path), *options]) as sim:
            sim.run(2_000_000)
            sim.ask("flush")
        first = {}
        for row in path.read_text().splitlines()[1:]:
            cycle, board, _, signal, level = row.split(",")
            if signal == "STEP" and level == "1":
                first.setdefault(int(board), int(cycle))
        return [first[board] for board in range(3)]

    def test_each_board_at_a_cycle_of_its_own(self):
        together = self.starts()
        self.assertEqual(together[0], together[2])
        apart = self.starts("--power-up-ms", "50")
        shifts = [a - b for a, b in zip(apart, together, strict=True)]
        self.assertEqual(len(set(shifts)), 3)
        self.assertTrue(all(0 < shift <= 800_000 + 10 for shift in shifts), shifts)
        self.assertEqual(self.starts("--power-up-ms", "50"), apart)
        self.assertNotEqual(self.starts("--power-up-ms", "50", "--seed", "2"), apart)

    def test_a_board_without_power_does_nothing(self):
        with Session(image("uno", "echo"), image("mega", "echo"),
                     options=["--power-up-ms", "40"]) as sim:  # fmt: skip
            self.assertEqual(sim.ask("tx 0107 16000").split()[1], "-")
            sim.run(800_000)
            self.assertEqual(sim.ask("tx 0107").split()[1], "0108")
            self.assertEqual(sim.ask("tx 0209").split()[1], "020a")


if __name__ == "__main__":
    unittest.main()
