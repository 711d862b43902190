# SPDX-License-Identifier: MIT
"""The runner itself: command line, control protocol, pixel clock, plant, files, verdicts."""

import itertools
import json
import math
import statistics
import subprocess
import time
import unittest
from fractions import Fraction
from pathlib import Path

from harness import HANG_S, SIM, Session, SimTest, call, differences, image, read_edges, rising


class CommandLine(unittest.TestCase):
    def refused(self, *arguments):
        """The one line that a wrong command line gets."""
        result = call(*arguments)
        self.assertEqual(result.returncode, 2, result)
        self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
        self.assertTrue(result.stderr.startswith("pixstep-sim: "), result.stderr)
        return result.stderr

    def test_help(self):
        result = call("--help")
        self.assertEqual(result.returncode, 0)
        self.assertIn("--control", result.stdout)

    def test_errors(self):
        good = image("uno", "echo")
        self.assertIn("no board", self.refused("--control"))
        self.assertIn("no mode", self.refused("--board", good))
        self.assertIn("unknown board 'duo'", self.refused("--board", "duo=x.elf", "--control"))
        self.assertIn("no such image", self.refused("--board", "uno=/nowhere.elf", "--control"))
        self.assertIn("not an AVR ELF", self.refused("--board", f"uno={__file__}", "--control"))
        self.assertIn("--run-ms 'x'", self.refused("--board", good, "--run-ms", "x"))
        self.assertIn(
            "--pixel-hz '0'",
            self.refused("--board", good, "--control", "--pixel-hz", "0"),
        )
        self.assertIn("only one of", self.refused("--board", good, "--control", "--pty"))
        self.assertIn(
            "'ploy'",
            self.refused("--board", good, "--control", "--plant", "0.0:ploy=1"),
        )
        self.assertIn(
            "no such axis",
            self.refused("--board", good, "--control", "--plant", "0.1:play=1"),
        )
        self.assertIn(
            "/nowhere/x",
            self.refused("--board", good, "--control", "--edges", "/nowhere/x"),
        )
        self.assertIn("unrecognized", self.refused("--borad", good))
        for wrong in ("0=3", "4=3", "1", "1=x", "1=20001"):
            self.refused("--board", good, "--board", good, "--control", "--oscillator-ppm", wrong)


class Statistics(unittest.TestCase):
    """`stats`: how long the program has run lies between two times of this one's clock."""

    MARGIN_S = 0.001  # the answer has so many places

    def test_the_time_on_the_wall(self):
        began = time.monotonic()
        with Session(image("uno", "echo")) as sim:
            sim.run(1)
            opened = time.monotonic()
            for _ in range(4):
                time.sleep(0.3)
                least = time.monotonic() - opened
                seen = json.loads(sim.ask("stats"))["wall_s"]
                most = time.monotonic() - began
                self.assertGreaterEqual(seen, least - self.MARGIN_S)
                self.assertLessEqual(seen, most + self.MARGIN_S)


class Control(unittest.TestCase):
    def test_errors_leave_the_session_alive(self):
        with Session(image("uno", "echo")) as sim:
            for command in (
                "jump",
                "run",
                "run x",
                "tx 0",
                "tx 0g",
                "steps 1 0",
                "steps 0 1",
            ):
                self.assertTrue(sim.ask(command).startswith("error "), command)
            self.assertEqual(sim.ask("run 1000"), "ok 1000")
            self.assertEqual(sim.ask("poke 0 0x500 12ab"), "ok")
            self.assertEqual(sim.ask("peek 0 0x500 2"), "mem 12ab")
            self.assertEqual(sim.ask("clock drop 3"), "ok")
            self.assertEqual(sim.ask("quit"), "ok")
            self.assertEqual(sim.process.wait(timeout=HANG_S), 0)

    def test_stats(self):
        with Session(image("mega", "intervals")) as sim:
            sim.run(1_600_000)
            stats = json.loads(sim.ask("stats"))
            steps = sim.ask("steps 0 0")
            counts = sim.ask("counts 0 0")
        board = stats["boards"][0]
        self.assertEqual(stats["cycle"], 1_600_000)
        self.assertEqual(board["name"], "mega")
        rising_steps = board["axes"][0]["steps_rising"]
        self.assertEqual(counts, f"counts {rising_steps}")
        self.assertEqual(steps, f"steps {rising_steps} 1600000")
        # main() and the handler together use some 20 of the Mega's 8192 bytes.
        self.assertLess(board["stack_used_bytes"], 40)
        self.assertGreater(board["stack_free_bytes"], 8000)


class PixelClock(SimTest):
    def clock(self, *options, commands=("run 32000000",), board="uno"):
        log = self.folder / "clock.csv"
        with Session(image(board, "echo"), options=["--clock-log", str(log), *options]) as sim:
            for command in commands:
                self.assertTrue(sim.ask(command).startswith("ok"), command)
        header, *rows = log.read_text().split()
        self.assertEqual(header, "cycle,true_cycle_x1000,edge")
        self.rows = [(int(a), int(b), kind) for a, b, kind in (row.split(",") for row in rows)]
        return [cycle for cycle, _, kind in self.rows if kind != "missing"]

    def true(self):
        """Return the ideal times of the true edges, missing ones included, in cycles."""
        return [Fraction(true, 1000) for _, true, kind in self.rows if kind != "false"]

    def test_exact_period(self):
        edges = self.clock("--pixel-hz", "30000/1001", "--pixel-start-ms", "5")
        period = Fraction(16_000_000 * 1001, 30_000)
        expected = [int(80_000 + k * period) for k in range(len(edges))]
        self.assertEqual(edges, expected)
        self.assertEqual(len(edges), 60)

    def test_pulses_keep_apart(self):
        """A jitter of more than a period: each pulse, a quarter of it, ends before the next."""
        options = ("--pixel-hz", "40000", "--pixel-jitter-ns", "40000", "--seed", "5")
        edges = self.clock(*options, commands=("run 4000000",))
        high, low = 400 // 4 + 1, 2
        self.assertEqual(min(b - a for a, b in itertools.pairwise(edges)), high + low)

    def test_exact_period_at_20_mhz(self):
        options = ("--pixel-hz", "30000/1001", "--pixel-start-ms", "5")
        edges = self.clock(*options, board="m1284")
        period = Fraction(20_000_000 * 1001, 30_000)
        self.assertEqual(edges, [int(100_000 + k * period) for k in range(len(edges))])
        self.assertEqual(len(edges), 48)

    def test_ppm(self):
        edges = self.clock("--pixel-hz", "1000", "--pixel-ppm", "-100")
        period = Fraction(16_000) / (1 - Fraction(100, 1_000_000))
        self.assertEqual(edges, [int(160_000 + k * period) for k in range(len(edges))])

    def test_jitter_is_bounded_and_repeatable(self):
        options = ["--pixel-hz", "100", "--pixel-jitter-ns", "5000", "--seed", "7"]
        edges = self.clock(*options)
        off = [edge - (160_000 + 160_000 * k) for k, edge in enumerate(edges)]
        self.assertLessEqual(max(off), 80)
        self.assertGreaterEqual(min(off), -80)
        self.assertGreater(len(set(off)), 20)
        self.assertEqual(self.clock(*options), edges)

    def test_normal_jitter(self):
        options = ("--pixel-hz", "1000", "--pixel-jitter-rms-ns", "5000", "--seed", "3")
        edges = self.clock(*options, commands=("run 64000000",))
        self.assertEqual(self.true(), [160_000 + 16_000 * k for k in range(len(edges))])
        off = [edge - true for edge, true in zip(edges, self.true(), strict=True)]
        self.assertAlmostEqual(statistics.fmean(off), 0, delta=5)
        self.assertAlmostEqual(statistics.pstdev(off), 80, delta=4)
        self.assertAlmostEqual(sum(abs(one) < 80 for one in off) / len(off), 0.683, delta=0.03)
        self.assertEqual(self.clock(*options, commands=("run 64000000",)), edges)

    def test_wander_and_step(self):
        options = ("--pixel-hz", "1000", "--pixel-ppm", "100", "--pixel-wander-ppm", "50")
        edges = self.clock(*options, "--pixel-step", "-1000@300")
        self.assertEqual(edges, [int(true) for true in self.true()])
        ppm = [(16_000 / float(b - a) - 1) * 1e6 for a, b in itertools.pairwise(self.true())]
        wanted = [
            100 + 50 * math.sin(2 * math.pi * k / 1000) - 1000 * (k >= 300) for k in range(len(ppm))
        ]
        worst = max(abs(a - b) for a, b in zip(ppm, wanted, strict=True))
        self.assertLess(worst, 0.2)  # a thousandth of a cycle in 16,000

    def test_missing_and_false_edges(self):
        options = ("--pixel-hz", "1000", "--pixel-drop", "20", "--pixel-double", "7")
        edges = self.clock(*options)
        self.assertEqual(self.true(), [160_000 + 16_000 * k for k in range(len(self.true()))])
        self.assertEqual(edges, sorted(edges))
        missing = [int(true) // 1000 for _, true, kind in self.rows if kind == "missing"]
        self.assertEqual(missing, [160_000 + 16_000 * k for k in range(19, len(self.true()), 20)])
        false = [(cycle, true // 1000) for cycle, true, kind in self.rows if kind == "false"]
        behind = [160_000 + 16_000 * k for k in range(3, len(self.true()), 7) if k % 20 != 19]
        self.assertEqual([true for _, true in false], behind[: len(false)])
        parts = [(cycle - true) / 16_000 for cycle, true in false]
        self.assertTrue(all(0.05 <= part <= 0.7 for part in parts))
        self.assertGreater(max(parts) - min(parts), 0.4)

    def test_drop_and_off(self):
        commands = [
            "run 200000",
            "clock drop 2",
            "run 500000",
            "clock off",
            "run 500000",
        ]
        commands += ["clock on", "run 300000"]
        edges = self.clock("--pixel-hz", "100", commands=commands)
        # Pulses at 160000 k: 2 and 3 dropped, 5, 6 and 7 off; run to 1500000.
        self.assertEqual(edges, [160_000 * k for k in (1, 4, 8, 9)])
        self.assertEqual(self.true(), [160_000 * k for k in (1, 2, 3, 4, 8, 9)])


class Plant(SimTest):
    def test_play_and_home(self):
        options = ["--plant", "0.0:play=40,home=100,hyst=8,start=60"]
        with Session(image("uno", "intervals"), options=options) as sim:
            sim.run(16_000)
            steps = int(sim.ask("counts 0 0").split()[1])
            motor, load = map(int, sim.ask("plant 0 0").split()[1:])
            self.assertEqual((motor, load), (60 + steps, 60 + steps))
            pinc = int(sim.ask("peek 0 0x26 1").split()[1], 16)
            self.assertEqual(pinc & 1, 1 if load < 100 else 0)  # HOME = PC0, to ground
            sim.run(160_000)
            sim.ask("poke 0 0x28 01")  # PORTC: has no effect on the wire (no write by the program)
            self.assertEqual(int(sim.ask("peek 0 0x26 1").split()[1], 16) & 1, 0)

    def test_hard_stop(self):
        options = ["--plant", "0.0:travel=-10..50,over=5"]
        with Session(image("uno", "intervals"), options=options) as sim:
            sim.run(160_000)
            self.assertEqual(sim.ask("plant 0 0"), "plant 55 55")


class PlantLog(SimTest):
    """images/turns.c: 5 steps up, 9 down, 3 up through a play of 4, starting at 100."""

    MOTOR = (100, *range(101, 106), *range(104, 95, -1), *range(97, 100))
    LOAD = (*range(100, 106), *[105] * 4, *range(104, 99, -1), *[100] * 3)

    def log(self, *boards, options):
        path = self.folder / "plant.csv"
        with Session(*boards, options=["--plant-log", str(path), *options]) as sim:
            sim.run(100_000)
            self.assertEqual(sim.ask("flush"), "ok")
            rows = path.read_text().splitlines()
        self.assertEqual(path.read_text().splitlines(), rows)  # complete after the flush
        self.assertEqual(rows[0], "cycle,board,axis,motor,load")
        return [tuple(map(int, row.split(","))) for row in rows[1:]]

    def test_motor_and_load_at_every_step(self):
        for board in ("uno", "mega"):
            edges = self.folder / "edges.csv"
            options = ["--plant", "0.0:play=4,start=100", "--edges", str(edges)]
            rows = self.log(image(board, "turns"), options=options)
            self.assertEqual(tuple(row[3] for row in rows), self.MOTOR)
            self.assertEqual(tuple(row[4] for row in rows), self.LOAD)
            self.assertEqual({row[1:3] for row in rows}, {(0, 0)})
            self.assertEqual([row[0] for row in rows], [0, *rising(read_edges(edges))])

    def test_boards_are_in_order_of_cycles(self):
        options = ["--plant", "0.0:play=4,start=100", "--plant", "1.0:start=-3"]
        rows = self.log(image("uno", "turns"), image("mega", "turns"), options=options)
        self.assertEqual([row[0] for row in rows], sorted(row[0] for row in rows))
        self.assertEqual(tuple(row[3] for row in rows if row[1] == 0), self.MOTOR)
        second = [row[3:] for row in rows if row[1] == 1]
        self.assertEqual((second[0], second[-1], len(second)), ((-3, -3), (-4, -4), 18))

    def test_only_axes_with_a_plant_and_only_what_moves(self):
        self.assertEqual(self.log(image("uno", "turns"), options=[]), [])
        # The hard stop at 102 swallows three of the five steps up.
        options = ["--plant", "0.0:travel=-50..100,over=2,start=100"]
        rows = self.log(image("uno", "turns"), options=options)
        self.assertEqual(max(row[3] for row in rows), 102)
        self.assertEqual(len(rows), 1 + 2 + 9 + 3)

    def test_a_log_that_cannot_be_written(self):
        result = call(
            "--board",
            image("uno", "turns"),
            "--run-ms",
            "1",
            "--plant-log",
            "/nowhere/x",
        )
        self.assertEqual(result.returncode, 2)
        self.assertIn("/nowhere/x: ", result.stderr)


class Files(SimTest):
    def test_vcd_and_edges_agree(self):
        vcd = self.folder / "waves.vcd"
        edges = self.folder / "edges.csv"
        options = ["--vcd", str(vcd), "--edges", str(edges), "--pixel-hz", "100"]
        boards = [image("uno", "intervals"), image("mega", "intervals")]
        with Session(*boards, options=options) as sim:
            sim.run(200_000)
            self.assertEqual(sim.ask("flush"), "ok")
        rows = read_edges(edges)
        self.assertEqual([r[0] for r in rows], sorted(r[0] for r in rows))
        self.assertEqual({r[1] for r in rows}, {0, 1})
        text = vcd.read_text()
        self.assertIn("$timescale 100 ps $end", text)
        step = next(line.split()[3] for line in text.splitlines() if line.endswith("STEP0 $end"))
        at, seen = 0, []
        for line in text.split("$dumpvars")[1].splitlines():
            if line.startswith("#"):
                at = int(line[1:])
            elif line == f"1{step}":
                seen.append(at / 625)
        self.assertEqual(seen, rising(rows, board=0))


class Watchdog(SimTest):
    """images/watchdog.c: a reset in the middle of a run; the time of the bench goes on."""

    def check(self, board):
        edges = self.folder / "edges.csv"
        options = ["--edges", str(edges), "--pixel-hz", "100"]
        boards = [image(board, "intervals"), image(board, "watchdog")]
        with Session(*boards, options=options) as sim:
            self.assertEqual(sim.run(100_000), "ok 100000")
            self.assertEqual(sim.results(1, board=1), [1])
            self.assertEqual(sim.run(500_000), "ok 600000")
            self.assertEqual(sim.results(3, board=1), [2, 2, 0])  # strap: second board
        gaps = differences(rising(read_edges(edges), board=1))
        # 15 ms (16 of the 128 kHz oscillator) of steps, one gap, steps again to the end.
        self.assertEqual(len([gap for gap in gaps if gap != 1000]), 1)
        self.assertGreater(len(gaps), 500)

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


class Verdict(unittest.TestCase):
    def test_failures_are_the_exit_status(self):
        for board in ("uno", "mega"):
            result = call("--unit", "--board", image(board, "verdict"))
            self.assertEqual((result.returncode, result.stdout), (3, "three failures\n"))

    def test_no_end_is_a_failure(self):
        result = call("--unit", "--unit-limit-ms", "20", "--board", image("uno", "intervals"))
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("no verdict within 20 ms", result.stderr)


class Pty(unittest.TestCase):
    def test_answers_a_client(self):
        command = [SIM, "--pty", "--board", image("uno", "echo")]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        try:
            name = process.stdout.readline().strip()
            with Path(name).open("r+b", buffering=0) as port:
                port.write(b"\x01\x41")
                answer = b""
                while len(answer) < 2:
                    answer += port.read(2 - len(answer))
            self.assertEqual(answer, b"\x01\x42")
        finally:
            process.terminate()
            process.wait(timeout=HANG_S)
            process.stdout.close()


class Speed(unittest.TestCase):
    def test_the_factor_is_simulated_by_elapsed_time(self):
        """How large it is depends on the machine: `pixstep bench` says it, no test does."""
        result = call("--board", image("uno", "intervals"), "--run-ms", "200")
        self.assertEqual(result.returncode, 0)
        self.assertGreater(json.loads(result.stdout)["realtime_factor"], 0.0)


if __name__ == "__main__":
    unittest.main()
