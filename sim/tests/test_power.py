# SPDX-License-Identifier: MIT
"""Power cuts and resets: causes, memories, outputs, the byte of EEPROM that is on its way."""

import json
import random
import time
import unittest

from harness import RESULT_ADDRESS, Session, SimTest, differences, image, read_edges, rising

BOARDS = ("uno", "mega")
BYTES = 64  # images/power.c writes these, one after the other
WRITE_CYCLES = 54_400
PORF, EXTRF, BORF = 1, 2, 4
STRAP = 0


def bytes_of(answer):
    return bytes.fromhex(answer.removeprefix("mem "))


class Board(Session):
    """images/power.c"""

    def __init__(self, board="uno", options=()):
        super().__init__(image(board, "power"), options=options)

    def ram(self, symbol):
        return int.from_bytes(bytes_of(self.ask(f"peek 0 {symbol}")), "little")

    def eeprom(self):
        return bytes_of(self.ask(f"eeprom 0 read 0 {BYTES}"))


class Causes(unittest.TestCase):
    def check(self, board):
        with Board(board) as sim:
            sim.run(10_000)
            self.assertEqual(sim.ram("cause"), PORF)
            sim.ask("poke 0 starts 07")
            for command, cause, starts in (
                ("reset 0 external", EXTRF, 8),
                ("reset 0 brownout", BORF, 9),
            ):
                self.assertTrue(sim.ask(command).startswith("ok "))
                sim.run(10_000)
                # RAM is kept; the start-up code has set .data and .bss anew.
                self.assertEqual((sim.ram("cause"), sim.ram("starts")), (cause, starts))
                self.assertEqual(sim.ram("known"), 1)
            self.assertTrue(sim.ask("cycle 0").startswith("ok "))
            sim.run(10_000)
            self.assertEqual(sim.ram("cause"), PORF)

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")

    def test_flags_add_up_until_cleared(self):
        with Board() as sim:  # before the program's first instruction
            sim.ask("reset 0 external")
            sim.ask("reset 0 brownout")
            sim.run(10_000)
            self.assertEqual(sim.ram("cause"), PORF | EXTRF | BORF)

    def test_errors(self):
        with Board() as sim:
            sim.run(1_000)
            for wrong in (
                "power 0 on",
                "power 0 of",
                "power 1 off",
                "reset 0 watchdog",
                "cycle 0 now",
                "reset 0 external at 999",
            ):
                self.assertTrue(sim.ask(wrong).startswith("error "), wrong)
            self.assertTrue(sim.ask("power 0 off").startswith("ok "))
            for wrong in ("power 0 off", "reset 0 external", "cycle 0", "hang 0 main"):
                self.assertIn("has no power", sim.ask(wrong), wrong)
            self.assertEqual(sim.run(1_000), "ok 2000")


class Registers(unittest.TestCase):
    """images/start.c: a start finds the registers as the data sheet has them."""

    def test_each_start(self):
        # UCSR0A: UDRE0. UCSR0C: 8 data bits. PINB at last, of which the test drives a pin.
        initial = [0x20, 0, 0x06, 0, 0, 0, 0, 0, 0, 0, 1]
        for board in BOARDS:
            with Session(image(board, "start")) as sim:
                sim.ask("pin 0 B 0 1")
                sim.run(20_000)
                for command in ("reset 0 external", "reset 0 brownout", "cycle 0"):
                    sim.ask(f"poke 0 {RESULT_ADDRESS} {'ff' * 22}")
                    self.assertTrue(sim.ask(command).startswith("ok "))
                    sim.run(20_000)
                    self.assertEqual(sim.results(11), initial, command)


class Off(SimTest):
    def test_outputs_and_counters(self):
        path = self.folder / "edges.csv"
        for board in BOARDS:
            with Board(board, options=["--edges", str(path)]) as sim:
                sim.run(50_000)
                self.assertEqual(sim.ask("permit 0").split()[1], "1")
                before = int(sim.ask("counts 0 0").split()[1])
                off = int(sim.ask("power 0 off").split()[1])
                self.assertIn(off, range(50_000, 50_030))
                self.assertEqual(sim.ask("permit 0").split()[1:4], ["0", "2", f"{off}"])
                self.assertEqual(sim.run(50_000), "ok 100000")
                self.assertEqual(int(sim.ask("counts 0 0").split()[1]), before)
                self.assertEqual(sim.ask("power 0 on"), "ok 100000")
                sim.run(50_000)
                after = int(sim.ask("counts 0 0").split()[1])
                sim.ask("flush")
            edges = read_edges(path)
            steps = rising(edges)
            self.assertEqual(after, len(steps))
            self.assertEqual([c for c in steps if off < c < 100_000], [])
            self.assertEqual(
                [e[0] for e in edges if e[3:] == ("ENABLE", 0)],
                [e[0] for e in edges if e[3:] == ("PERMIT", 0)],
            )
            # One long gap, and the step's period is exact again after it.
            gaps = differences(steps)
            self.assertEqual(len([gap for gap in gaps if gap != 1000]), 1)

    def test_permit_in_the_waveforms(self):
        path = self.folder / "waves.vcd"
        with Board("mega", options=["--vcd", str(path)]) as sim:
            sim.run(20_000)
            on = int(sim.ask("permit 0").split()[3])
            off = int(sim.ask("power 0 off").split()[1])
            sim.run(20_000)
            sim.ask("flush")
        lines = path.read_text().splitlines()
        name = next(line.split()[3] for line in lines if line.endswith(" PERMIT $end"))
        at, seen = 0, []
        for line in lines[lines.index("$end", lines.index("$dumpvars")) :]:
            at = int(line[1:]) // 625 if line.startswith("#") else at
            if line[1:] == name:
                seen.append((at, line[0]))
        self.assertEqual(seen, [(on, "1"), (off, "0")])

    def test_ram_is_noise_and_the_same_with_the_same_seed(self):
        def noises(seed):
            with Board(options=["--seed", str(seed)]) as sim:
                sim.run(1_000)
                found = []
                for _ in range(2):
                    sim.ask("cycle 0")
                    found.append(bytes_of(sim.ask("peek 0 0x100 2048")))
                    sim.run(1_000)
                return found

        first, second = noises(1)
        self.assertGreater(len(set(first)), 200)
        self.assertNotEqual(first, second)
        self.assertEqual(noises(1), [first, second])
        self.assertNotEqual(noises(2)[0], first)

    def test_stack_watch_goes_on(self):
        with Board("mega") as sim:
            sim.run(100_000)
            used = json.loads(sim.ask("stats"))["boards"][0]["stack_used_bytes"]
            sim.ask("cycle 0")
            sim.run(100_000)
            again = json.loads(sim.ask("stats"))["boards"][0]["stack_used_bytes"]
        self.assertLess(used, 60)
        self.assertLessEqual(abs(again - used), 2)  # a byte of noise may look untouched

    def test_a_frame_on_its_way_is_cut(self):
        # The second byte's frame begins when the first write of EEPROM has ended and lasts 1360.
        for command in ("power 0 off", "reset 0 external", None):
            with Board("uno") as sim:
                sim.run(50_000)
                if command:
                    sim.ask(f"{command} at 55500")
                heard = sim.ask("tx 00 8000").split()[1]
            self.assertEqual(heard, "fe" if command else "01")  # ~1: a framing error

    def test_planned(self):
        with Board() as sim:
            for command in (
                "power 0 off at 20000",
                "power 0 on at 40000",
                "reset 0 external at 60000",
                "cycle 0 at 80000",
                "pin 0 C 3 1 at 80000",
            ):
                self.assertEqual(sim.ask(command), "ok")
            sim.run(30_000)
            counts = sim.ask("counts 0 0")
            sim.run(9_000)
            self.assertEqual(sim.ask("counts 0 0"), counts)
            sim.run(11_000)
            self.assertNotEqual(sim.ask("counts 0 0"), counts)
            self.assertEqual(sim.ram("cause"), PORF)
            sim.run(20_000)
            self.assertEqual(sim.ram("cause"), EXTRF)
            sim.run(20_000)
            self.assertEqual(sim.ram("cause"), PORF)
            self.assertEqual(sim.ask("peek 0 0x26 1"), "mem 08")


class Eeprom(unittest.TestCase):
    def test_only_the_byte_on_its_way_is_spoiled(self):
        """Cuts at random cycles; each start rewrites the same bytes with another value."""
        randoms = random.Random(1)
        outcomes = {"old": 0, "new": 0, "other": 0}
        with Board() as sim:
            sim.ask("poke 0 starts 00")
            sim.run(BYTES * WRITE_CYCLES + 100_000)
            for start in range(1, 200):
                before = sim.eeprom()
                sim.run(randoms.randrange(1_000, 6 * WRITE_CYCLES))
                state = sim.ask("eeprom 0 state").split()
                number = sim.ram("starts")
                self.assertTrue(sim.ask("cycle 0").startswith("ok "))
                sim.ask(f"poke 0 starts {start:02x}")
                after = sim.eeprom()
                cut = int(state[2])
                self.assertEqual(after[:cut], bytes([number] * cut))
                self.assertEqual(after[cut + 1 :], before[cut + 1 :])
                kind = {before[cut]: "old", number: "new"}.get(after[cut], "other")
                outcomes[kind] += 1
        self.assertGreater(outcomes["other"], 100)
        self.assertEqual(sum(outcomes.values()), 199)

    def test_a_cut_byte_is_half_erased_or_half_written(self):
        """An erase raises bits, a write then lowers them; half of the cuts leave anything."""
        whole, erased, written = {False: 0, True: 0}, [], []
        randoms = random.Random(2)
        with Board() as sim:
            sim.ask("poke 0 starts 00")
            sim.run(20_000)
            for start in range(160):
                sim.ask("eeprom 0 write 0 5a")
                self.assertTrue(sim.ask("cycle 0").startswith("ok "))
                sim.ask("poke 0 starts c2")
                sim.run(4_000)
                number = sim.ram("starts")
                left = int(sim.ask("eeprom 0 state").split()[3])
                sim.run(randoms.randrange(left - 1000))
                erases = int(sim.ask("eeprom 0 state").split()[3]) > WRITE_CYCLES // 2
                sim.ask("power 0 off")
                byte = sim.eeprom()[0]
                (erased if erases else written).append(byte)
                kept = 0x5A if erases else number
                whole[erases] += byte & kept == kept
                sim.ask("power 0 on")
                sim.run(start)
        for found, kept in ((erased, whole[True]), (written, whole[False])):
            self.assertGreater(len(found), 50)
            self.assertGreater(len(set(found)), 20)
            # By chance a sixteenth of the others, too.
            self.assertIn(kept, range(len(found) * 4 // 10, len(found) * 7 // 10))

    def test_a_reset_lets_the_write_end(self):
        for command in ("reset 0 external", "reset 0 brownout"):
            with Board() as sim:
                sim.run(20_000)
                number = sim.ram("starts")
                left = int(sim.ask("eeprom 0 state").split()[3])
                sim.ask(command)
                # The program begins anew and waits for EEPE: then it writes the first byte again.
                self.assertEqual(int(sim.ask("eeprom 0 state").split()[3]), left)
                sim.run(left + 200)
                self.assertEqual(sim.eeprom()[0], number)
                self.assertEqual(sim.ask("eeprom 0 state").split()[1:3], ["2", "0"])

    def test_a_write_ends_by_itself_after_a_reset(self):
        """No program looks at it: nothing runs after the reset."""
        for command in ("reset 0 external", "reset 0 brownout"):
            with Board() as sim:
                sim.run(20_000)
                number = sim.ram("starts")
                left = int(sim.ask("eeprom 0 state").split()[3])
                before = sim.eeprom()
                self.assertNotEqual(before[0], number)
                sim.ask("hang 0 interrupts kept")
                sim.ask(command)
                sim.run(left - 100)
                self.assertEqual(sim.eeprom(), before)
                sim.run(200)
                self.assertEqual(sim.eeprom(), bytes([number]) + before[1:])


class Speed(unittest.TestCase):
    def test_thousands_of_cuts(self):
        with Board("mega") as sim:
            began = time.process_time()
            for _ in range(2_000):
                sim.ask("cycle 0")
                sim.run(1_000)
            cpu_s = json.loads(sim.ask("stats"))["cpu_s"]
            self.assertEqual(sim.run(0), "ok 2000000")
        self.assertLess(cpu_s, 4.0)
        self.assertLess(time.process_time() - began, 4.0)


if __name__ == "__main__":
    unittest.main()
