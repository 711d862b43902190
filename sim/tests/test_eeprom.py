# SPDX-License-Identifier: MIT
"""The EEPROM model against the data sheet: timed sequence, times, halts, EE_READY, files."""

import unittest

from harness import GPIOR2, Session, SimTest, call, image

BOARDS = ("uno", "mega")
SIZE = {"uno": 1024, "mega": 4096}
BOTH_CYCLES, HALF_CYCLES = 54_400, 28_800  # 3.4 ms, 1.8 ms
EEPE = 2
# The time is read some instructions after EEPE is set and up to a turn of a loop after it is clear.
SOONEST, LATEST = -20, 10


def bytes_of(answer):
    return bytes.fromhex(answer.removeprefix("mem "))


class Registers(unittest.TestCase):
    """images/eeprom.c"""

    def check(self, board):
        with Session(image(board, "eeprom")) as sim:
            self.assertEqual(sim.run(2_000_000), "ok 2000000")
            results = sim.results(20)
            first = bytes_of(sim.ask("eeprom 0 read 0x10 2"))
            stored = bytes_of(sim.ask("eeprom 0 read stored"))
            end = bytes_of(sim.ask(f"eeprom 0 read {SIZE[board] - 1} 1"))
            state = sim.ask("eeprom 0 state")
        # sbi writes in its second cycle: with two nops between them that is the fourth one.
        self.assertEqual(results[0], EEPE)
        self.assertEqual(results[1], 0)
        self.assertEqual(first, b"\x5a\xff")
        # sbi 2, lds 2, and the CPU halted for 2 and 4 cycles.
        self.assertEqual(results[2:4], [2 + 2 + 2, 2 + 4 + 2])
        for time, expected in ((4, BOTH_CYCLES), (6, HALF_CYCLES), (8, HALF_CYCLES)):
            self.assertIn(results[time] - expected, range(SOONEST, LATEST))
        self.assertEqual(results[5], 0x3C)
        self.assertEqual(results[7], 0x3C & 0x0F)  # write only: clears bits, sets none
        self.assertEqual(results[9], 0xFF)  # erase only
        self.assertEqual(results[10:12], [0x14, 0])  # neither EEAR nor EEPM moves while busy
        # Constant: one instruction of the main program, then EE_READY again.
        self.assertGreater(results[12], 40)
        self.assertEqual(results[13], 0)
        self.assertGreater(results[14], 40)
        self.assertEqual(results[15], 0)
        self.assertEqual(results[16:18], [SIZE[board] - 1, 0x99])
        self.assertEqual(end, b"\x99")
        self.assertEqual(stored, b"\xff\x42\xff\xff")
        self.assertEqual(results[18:20], [0x42, 0x600D])
        self.assertEqual(state, "eeprom 9 - 0")

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


class Ready(unittest.TestCase):
    """images/ready.c: the program never looks at EECR again."""

    def test_the_end_of_a_write_comes_by_itself(self):
        for board in BOARDS:
            with self.subTest(board=board), Session(image(board, "ready")) as sim:
                self.assertEqual(sim.run(BOTH_CYCLES - 200), f"ok {BOTH_CYCLES - 200}")
                self.assertEqual(sim.results(2)[1], 0)
                sim.run(10_000)
                when, count = sim.results(2)
                self.assertEqual(count, 1)
                # The write begins some instructions behind the timer; the response and the stores.
                self.assertIn(when - BOTH_CYCLES, range(0, 60))
                self.assertEqual(bytes_of(sim.ask("eeprom 0 read 7 1")), b"\xa5")


REFUSALS = {
    1: "EEPROM: EEPM1:0 = 3 is reserved",
    2: "EEPROM: EERE set while byte 0x020 is being written",
    3: "EEPROM: EEDR written while byte 0x020 is being written",
    4: "EEPROM: EEPE set while byte 0x020 is being written",
    5: "EEPROM: EEPE and EERE set at once",
}


class Refused(unittest.TestCase):
    def test_each(self):
        for case, text in REFUSALS.items():
            with self.subTest(case=case), Session(image("uno", "eeprom")) as sim:
                self.assertEqual(sim.ask(f"poke 0 {GPIOR2} {case:02x}"), "ok")
                answer = sim.run(100_000)
                self.assertTrue(answer.startswith(f"error board 0 (uno): {text}"), answer)


class Commands(unittest.TestCase):
    def test_state_names_the_byte_on_its_way(self):
        with Session(image("uno", "power")) as sim:
            sim.run(20_000)
            writes, address, left = sim.ask("eeprom 0 state").split()[1:]
            self.assertEqual((writes, address), ("1", "0"))
            sim.run(int(left) + 40)
            self.assertEqual(sim.ask("eeprom 0 state").split()[1:3], ["2", "1"])

    def test_written_and_read(self):
        with Session(image("mega", "echo")) as sim:
            self.assertEqual(sim.ask("eeprom 0 read 0 4"), "mem ffffffff")
            self.assertEqual(sim.ask("eeprom 0 write 4094 12ab"), "ok")
            self.assertEqual(sim.ask("eeprom 0 read 4093 3"), "mem ff12ab")
            for wrong in (
                "read",
                "read 4096 1",
                "read 4095 2",
                "write 4095 0102",
                "write 0",
            ):
                self.assertTrue(sim.ask(f"eeprom 0 {wrong}").startswith("error "), wrong)
            self.assertEqual(sim.ask("eeprom 0 read 0 1"), "mem ff")


class Files(SimTest):
    def setUp(self):
        super().setUp()
        self.path = self.folder / "eeprom.bin"

    def session(self, path=None):
        return Session(image("uno", "echo"), options=["--eeprom", f"0={path or self.path}"])

    def test_kept_from_run_to_run(self):
        with self.session() as sim:
            sim.ask("eeprom 0 write 7 11")
            self.assertFalse(self.path.exists())
            self.assertEqual(sim.ask("flush"), "ok")
            self.assertEqual(self.path.read_bytes(), b"\xff" * 7 + b"\x11" + b"\xff" * 1016)
            sim.ask("eeprom 0 write 8 22")
        with self.session() as sim:  # the first one's end has written it
            self.assertEqual(sim.ask("eeprom 0 read 6 4"), "mem ff1122ff")
        self.assertEqual([p.name for p in self.folder.iterdir()], ["eeprom.bin"])

    def test_a_short_file_is_the_first_bytes(self):
        self.path.write_bytes(b"\x01\x02")
        with self.session() as sim:
            self.assertEqual(sim.ask("eeprom 0 read 0 3"), "mem 0102ff")

    def refused(self, option):
        result = call("--board", image("uno", "echo"), "--run-ms", "1", "--eeprom", option)
        self.assertEqual(result.returncode, 2, result)
        self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
        return result.stderr

    def test_errors(self):
        self.path.write_bytes(bytes(1025))
        self.assertIn(f"{self.path}: more than 1024 bytes", self.refused(f"0={self.path}"))
        self.assertEqual(self.path.stat().st_size, 1025)
        self.assertIn("BOARD=FILE", self.refused(str(self.path)))
        self.assertIn("no such board", self.refused(f"1={self.path}"))
        self.assertIn("/nowhere/x: ", self.refused("0=/nowhere/x"))


if __name__ == "__main__":
    unittest.main()
