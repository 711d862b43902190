# SPDX-License-Identifier: MIT
"""--wire-log: every edge of a pin from outside and every frame, as another simulator needs them."""

import tempfile
import unittest
from pathlib import Path

from harness import Session, SimTest, image

BIT_X1000 = 138_888  # 115200 baud
PIXEL_CLOCK = ["--pixel-hz", "100", "--pixel-start-ms", "1"]


class WireLog(SimTest):
    """images/echo.c: the master's frames, pins by command, the pixel clock."""

    def rows(self, commands):
        with tempfile.TemporaryDirectory() as folder:
            log = Path(folder) / "wires.csv"
            options = [*PIXEL_CLOCK, "--wire-log", str(log)]
            with Session(image("uno", "echo"), options=options) as sim:
                for command in commands:
                    sim.ask(command)
                sim.ask("flush")
                header, *rows = log.read_text().split()
        self.assertEqual(header, "cycle,wire,levels,bit_cycles_x1000")
        return [row.split(",") for row in rows]

    def test_pins(self):
        again = ["pin 0 D 2 1 at 500", "pin 0 D 2 1 at 600", "pin 0 D 2 0 at 700"]
        rows = self.rows([*again, "run 17000"])
        self.assertEqual([row[:3] for row in rows[:2]], [["500", "D2", "1"], ["700", "D2", "0"]])
        clock = [["16000", "B0", "1", "0"], ["16800", "B0", "0", "0"]]
        self.assertEqual(rows[2:], clock)

    def test_frames(self):
        """Start bit, eight bits from the lowest, even parity, stop bit; none of the board's own."""
        rows = self.rows(["run 1000", "tx 0107"])
        frames = [row for row in rows if row[1] == "RXD"]
        self.assertEqual([row[2] for row in frames], ["01000000011", "01110000011"])
        self.assertEqual([int(row[3]) for row in frames], [BIT_X1000] * 2)
        self.assertEqual([int(row[0]) for row in frames], [1000, 1000 + 11 * BIT_X1000 // 1000])

    def test_parity(self):
        odd = self.rows(["baud 9600 O", "send 01", "run 100"])
        none = self.rows(["baud 9600 N", "send 01", "run 100"])
        self.assertEqual([row[2] for row in (*odd, *none)], ["01000000001", "0100000001"])


if __name__ == "__main__":
    unittest.main()
