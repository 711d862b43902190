# SPDX-License-Identifier: MIT
"""The UART model and the shared line: frame times, flags, overrun, four boards in lock step."""

import tempfile
import unittest
from pathlib import Path

from harness import Session, SimTest, image

BIT = 136  # UBRR0 = 16 with U2X0: 8 * 17 cycles, 117647 baud
FRAME = 11 * BIT
SILENCE = 28_000  # 1750 us
MASTER_FRAME = 16_000_000 * 11 / 115_200

RXC, UDRE, TXC, DOR = 0x80, 0x20, 0x40, 0x08


class Registers(unittest.TestCase):
    """images/uart.c"""

    def check(self, board):
        with Session(image(board, "uart")) as sim:
            sim.run(20_000)
            before = sim.results(6)
            # Two characters are buffered, the third waits in the shift register, the fourth runs it
            # over: 1, 2 and 4 arrive, with DOR0 until UDR0 is read.
            answer = sim.ask("tx 01020304 1000")
            self.assertTrue(answer.startswith("rx - "), answer)
            sim.ask("poke 0 0x60a 02")
            sim.run(2_000)
            after = sim.results(15)
        # sts writes UDR0 in its second cycle a; the frame starts at a + 1 and ends 1496 later. With
        # N nops between them the lds reads at a + 2 + N.
        self.assertEqual(before[0], 0)  # N = 1494: one cycle too early
        self.assertEqual(before[1], TXC)  # N = 1495
        self.assertEqual(before[2], UDRE)
        self.assertEqual(before[3], 0)
        self.assertEqual(before[4], UDRE)
        self.assertEqual(before[5], 1)
        self.assertEqual(after[6:8], [RXC | DOR, 1])
        self.assertEqual(after[8:10], [RXC, 2])
        self.assertEqual(after[10:12], [RXC, 4])
        self.assertEqual(after[12], 0)
        self.assertEqual(after[14], 0x600D)

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


class SharedLine(SimTest):
    """images/echo.c on one to four boards."""

    def test_time_of_an_answer(self):
        with Session(image("mega", "echo")) as sim:
            sim.run(16_000)
            answer, cycle = sim.ask("tx 0141").split()[1:]
        self.assertEqual(answer, "0142")
        end = int(cycle) - SILENCE
        # The board hears the last byte in the middle of its stop bit (by its own clock), decides in
        # less than 100 cycles and sends two frames.
        heard = 16_000 + MASTER_FRAME + 10.5 * BIT
        self.assertGreater(end, heard + 2 * FRAME)
        self.assertLess(end, heard + 2 * FRAME + 100)

    def test_serial_log(self):
        with tempfile.TemporaryDirectory() as folder:
            log = Path(folder) / "serial.csv"
            with Session(image("uno", "echo"), options=["--serial-log", str(log)]) as sim:
                sim.run(16_000)
                sim.ask("tx 0141")
                sim.ask("flush")
                header, *rows = log.read_text().split()
        self.assertEqual(header, "cycle,direction,byte")
        rows = [row.split(",") for row in rows]
        self.assertEqual(
            [row[1:] for row in rows],
            [["rx", "01"], ["rx", "41"], ["tx", "01"], ["tx", "42"]],
        )
        first, second, sent, last = (int(row[0]) for row in rows)
        self.assertEqual(first, 16_000 + 10 * BIT + BIT // 2)
        self.assertEqual(second - first, int(MASTER_FRAME))
        self.assertIn(sent - second, range(1, 100))
        self.assertEqual(last - sent, FRAME)

    def test_four_boards(self):
        boards = [image("mega", "echo"), image("uno", "echo")] * 2
        with Session(*boards) as sim:
            sim.run(16_000)
            for round_number in range(5):
                for address in (1, 2, 3, 4):
                    value = 0x10 * round_number + address
                    answer = sim.ask(f"tx {address:02x}{value:02x}").split()[1]
                    self.assertEqual(answer, f"{address:02x}{value + 1:02x}")
            self.assertEqual(sim.ask("tx 0541 160000").split()[1], "-")

    def test_lock_step_is_repeatable(self):
        def run():
            with Session(image("uno", "echo"), image("mega", "echo")) as sim:
                sim.run(20_001)
                return [sim.ask(f"tx {a:02x}55") for a in (1, 2, 1, 2)]

        self.assertEqual(run(), run())


if __name__ == "__main__":
    unittest.main()
