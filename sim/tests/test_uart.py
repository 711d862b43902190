# SPDX-License-Identifier: MIT
"""The UART model and the shared line: frame times, flags, overrun, four boards in lock step."""

import tempfile
import unittest
from pathlib import Path

from harness import GPIOR2, Session, SimTest, image, read_edges

BIT = 136  # UBRR0 = 16 with U2X0: 8 * 17 cycles, 117647 baud
FRAME = 11 * BIT
SILENCE = 28_000  # 1750 us
MASTER_FRAME = 16_000_000 * 11 / 115_200

RXC, UDRE, TXC, FE, DOR, UPE = 0x80, 0x20, 0x40, 0x10, 0x08, 0x04

# A bit is decided behind the last of its three samples in the middle: 6 of 8 (U2X0), 10 of 16.
DECIDED = BIT * 6 // 8
BEFORE_STOP = 10 * BIT
SLOW_BIT = 144  # UBRR0 = 8 without U2X0: 16 * 9 cycles
RESPONSE = {"uno": 4, "mega": 5}


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
            sim.ask("poke 0 0x61e ffff")
            sim.ask("reset 0 external")
            sim.run(100)
            self.assertEqual(sim.results(16)[15], 0)  # of before the reset nothing is left
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
        self.assertEqual(after[12:14], [0, 4])  # nothing new: the character of before
        self.assertEqual(after[14], 0x600D)

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


class Frames(SimTest):
    """images/frames.c"""

    def check(self, board):
        log = self.folder / "serial.csv"
        with Session(image(board, "frames"), options=["--serial-log", str(log)]) as sim:
            sim.run(60_000)
            results = sim.results(7)
            sim.ask("flush")
        # As in images/uart.c: with N nops the lds reads N + 2 cycles behind the sts, and the frame
        # ends 1 + 12 * 136 behind it.
        self.assertEqual(results[:4], [0, TXC, 0, TXC])
        self.assertEqual(results[4:6], [UDRE, 0])
        self.assertEqual(results[6], 0x600D)
        rows = [row.split(",") for row in log.read_text().split()[1:]]
        self.assertEqual([row[2] for row in rows], ["15", "15", "15", "15", "11", "12"])
        self.assertEqual(int(rows[5][0]) - int(rows[4][0]), 12 * BIT)

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


class Levels(unittest.TestCase):
    """images/levels.c: an interrupt comes again for as long as its cause lasts."""

    def check(self, board):
        with Session(image(board, "levels")) as sim:
            sim.run(16_000)
            sim.ask("send 3132")
            sim.run(3 * FRAME)
            sim.ask("poke 0 0x600 0100")
            sim.run(8_000)
            # Both characters that wait, then an empty transmitter until it is switched off.
            self.assertEqual(sim.results(6), [1, 2, 0x31, 0x32, 5, 0x600D])
            # The frame's end raises an interrupt that is enabled after it, once.
            sim.run(8_000)
            self.assertEqual(sim.results(7)[6], 1)

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


class Driver(unittest.TestCase):
    """images/driver.c: the last half of the stop bit carries nothing."""

    def check(self, board):
        # The STS writes in its second cycle a, the frame begins at a + 1; the CBI's write, in its
        # second cycle, is in force one later: 8 cycles a unit, the last without its jump, and 2.
        enough = FRAME - BIT // 2
        with Session(image(board, "driver")) as sim:
            sim.run(16_000)
            for units in (60, (enough - 8) // 8, (enough + 8) // 8, 200):
                answer = sim.ask(f"tx {units:02x}").split()[1]
                self.assertEqual(answer, "5a" if 8 * units > enough else "a5", units)

    def test_uno(self):
        self.check("uno")

    def test_mega(self):
        self.check("mega")


class LastCycle(unittest.TestCase):
    """images/driver.c answers by one character."""

    def test_an_answer_that_ends_with_the_time_for_it_is_one(self):
        for board in ("uno", "mega"):

            def ask(command, board=board):
                with Session(image(board, "driver")) as sim:
                    sim.run(16_000)
                    return sim.ask(command).split()[1:]

            sent = int(ask("send c8")[0])
            answer, cycle = ask("tx c8")
            end = int(cycle) - SILENCE
            for timeout in range(end - sent - 2, end - sent + 3):
                self.assertEqual(ask(f"tx c8 {timeout}"), [answer, cycle], timeout)


class Receiver(SimTest):
    """images/receiver.c"""

    def open(self, board, *options):
        return Session(image(board, "receiver"), options=options)

    def take(self, sim, count, off_before=False):
        """(status, data) of the next characters, as the program reads them one behind the other."""
        sim.ask(f"poke 0 0x600 {count:02x}{off_before:02x}")
        sim.run(400)
        results = sim.results(1 + 2 * count)
        self.assertEqual(results[0], 0)
        return list(zip(results[1::2], results[2::2], strict=True))

    def awake(self, sim):
        """Ends the sleep: the handler's interrupt is off from here on."""
        sim.ask("poke 0 0x600 0100")
        sim.ask("send 00")
        sim.run(2 * FRAME)

    def check_instant(self, board):
        path = self.folder / "edges.csv"
        with self.open(board, "--edges", str(path)) as sim:
            sim.run(20_000)
            sim.ask("send 55")
            sim.run(2 * FRAME)
        (seen,) = [e[0] for e in read_edges(path) if e[3:] == ("PERMIT", 1)]
        # Woken: response, 4 more from sleep, RJMP, and SBI, whose write is in its second cycle.
        self.assertEqual(seen, 20_000 + BEFORE_STOP + DECIDED + RESPONSE[board] + 4 + 2 + 2)

    def check_instant_at_normal_speed(self, board):
        path = self.folder / "edges.csv"
        with self.open(board, "--edges", str(path)) as sim:
            sim.ask(f"poke 0 {GPIOR2} 80")
            sim.ask("baud 111111 E")
            sim.run(20_000)
            sim.ask("send 55")
            sim.run(2 * FRAME)
        (seen,) = [e[0] for e in read_edges(path) if e[3:] == ("PERMIT", 1)]
        decided = 10 * SLOW_BIT + SLOW_BIT * 10 // 16
        self.assertEqual(seen, 20_000 + decided + RESPONSE[board] + 4 + 2 + 2)

    def check_other_data_bits(self, board):
        """What is sent with 8 data bits is none of 7."""
        with self.open(board) as sim:
            sim.ask(f"poke 0 {GPIOR2} 40")
            sim.run(20_000)
            self.awake(sim)
            self.take(sim, 3)
            sim.ask("send 35")
            sim.run(3 * FRAME)
            status, data = self.take(sim, 1)[0]
            self.assertEqual(status, RXC | FE)
            self.assertNotEqual(data, 0x35)

    def check_errors_are_those_of_the_oldest(self, board):
        """Each character keeps its own: a wrong parity before a right one, and after it."""
        with self.open(board) as sim:
            sim.run(20_000)
            self.awake(sim)
            for order, wanted in (("OE", [UPE, 0]), ("EO", [0, UPE])):
                self.take(sim, 3)
                for data, parity in zip(("31", "32"), order, strict=True):
                    sim.ask(f"baud 115200 {parity}")
                    sim.ask(f"send {data}")
                sim.run(3 * FRAME)
                got = self.take(sim, 2)
                self.assertEqual(got, [(RXC | wanted[0], 0x31), (RXC | wanted[1], 0x32)])

    def check_overrun_at_the_start_bit(self, board):
        """The fourth character's start bit runs the third over, not its end."""
        master_frame = int(MASTER_FRAME)
        for late, wanted in (
            (-60, [(RXC, 1), (RXC, 2), (RXC, 3)]),  # taken before the start bit is decided
            (60, [(RXC | DOR, 1), (RXC, 2)]),
        ):
            with self.open(board) as sim:
                sim.run(20_000)
                self.awake(sim)
                start = int(sim.ask("send 01020304").split()[1]) - master_frame
                now = int(sim.run(1).split()[1])
                sim.run(start + DECIDED + late - now)
                got = self.take(sim, 4)
                self.assertEqual(got[: len(wanted)], wanted, late)
                self.assertEqual(got[len(wanted)][0] & RXC, 0)
                sim.run(2 * FRAME)
                self.assertEqual(self.take(sim, 2)[0], (RXC, 4))

    def check_errors(self, board):
        """A wrong parity is UPE0 and its character whole; a wrong rate is FE0."""
        with self.open(board) as sim:
            sim.run(20_000)
            self.awake(sim)
            for command, status in (
                ("115200 E", 0),
                ("115200 O", UPE),
                ("57600 E", FE),
            ):
                self.take(sim, 3)
                sim.ask(f"baud {command}")
                sim.ask("send 35")
                sim.run(4 * FRAME)
                got = self.take(sim, 1)[0]
                self.assertEqual(got[0], RXC | status, command)
                self.assertEqual(got[1] == 0x35, status != FE, command)

    def check_switched_off(self, board):
        """Disabling the receiver flushes its buffer."""
        with self.open(board) as sim:
            sim.run(20_000)
            self.awake(sim)
            for off_before, left in ((False, RXC), (True, 0)):
                self.take(sim, 3)
                sim.ask("send 1122")
                sim.run(3 * FRAME)
                self.assertEqual(self.take(sim, 1, off_before)[0][0], left)

    def test_uno(self):
        self.check_switched_off("uno")
        self.check_instant("uno")
        self.check_overrun_at_the_start_bit("uno")
        self.check_errors("uno")
        self.check_errors_are_those_of_the_oldest("uno")
        self.check_other_data_bits("uno")
        self.check_instant_at_normal_speed("uno")

    def test_mega(self):
        self.check_switched_off("mega")
        self.check_instant("mega")
        self.check_overrun_at_the_start_bit("mega")
        self.check_errors("mega")
        self.check_errors_are_those_of_the_oldest("mega")
        self.check_other_data_bits("mega")
        self.check_instant_at_normal_speed("mega")


class SharedLine(SimTest):
    """images/echo.c on one to four boards."""

    def test_time_of_an_answer(self):
        with Session(image("mega", "echo")) as sim:
            sim.run(16_000)
            answer, cycle = sim.ask("tx 0141").split()[1:]
        self.assertEqual(answer, "0142")
        end = int(cycle) - SILENCE
        # The board hears the last byte in its stop bit (by its own clock), decides in less than 100
        # cycles and sends two frames.
        heard = 16_000 + MASTER_FRAME + BEFORE_STOP + DECIDED
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
        self.assertEqual(first, 16_000 + BEFORE_STOP + DECIDED)
        self.assertEqual(second - first, int(MASTER_FRAME))
        self.assertIn(sent - second, range(1, 100))
        self.assertEqual(last - sent, FRAME)

    def test_a_board_sends_with_its_own_parity(self):
        with Session(image("uno", "echo")) as sim:
            sim.run(16_000)
            sim.ask("poke 0 0xc2 36")  # UCSR0C: odd
            for parity, answer in (("O", "0142"), ("E", "febd")):  # all of its bits are wrong
                sim.ask(f"baud 115200 {parity}")
                self.assertEqual(sim.ask("tx 0141").split()[1], answer, parity)

    def test_a_receiver_that_is_off_hears_nothing(self):
        with Session(image("uno", "echo")) as sim:
            sim.run(16_000)
            for enabled, answer in (("08", "-"), ("18", "0142")):
                sim.ask(f"poke 0 0xc1 {enabled}")  # UCSR0B: TXEN0, and RXEN0 beside it
                self.assertEqual(sim.ask("tx 0141 60000").split()[1], answer, enabled)

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

    def test_a_collision_damages_both_frames(self):
        """The master speaks into the first or the second byte of a board's answer."""
        for late, damaged in ((10, 0), (1700, 1)):
            with tempfile.TemporaryDirectory() as folder:
                log = Path(folder) / "serial.csv"
                boards = [image("uno", "echo"), image("mega", "echo")]
                with Session(*boards, options=["--serial-log", str(log)]) as sim:
                    sim.run(16_000)
                    end = int(sim.ask("send 0241").split()[1])
                    sim.run(end - 16_000 + late)
                    sim.ask("send 5a")
                    sim.run(8 * FRAME)
                    sim.ask("flush")
                    rows = [row.split(",") for row in log.read_text().split()[1:]]
            answer = [0x02, 0x42]
            answer[damaged] ^= 0xFF
            heard = [int(byte, 16) for _, direction, byte in rows if direction == "rx"]
            self.assertEqual(sorted(heard[2:]), sorted([*answer, 0x5A ^ 0xFF]), late)

    def test_lock_step_is_repeatable(self):
        def run():
            with Session(image("uno", "echo"), image("mega", "echo")) as sim:
                sim.run(20_001)
                return [sim.ask(f"tx {a:02x}55") for a in (1, 2, 1, 2)]

        self.assertEqual(run(), run())


if __name__ == "__main__":
    unittest.main()
