# SPDX-License-Identifier: MIT
"""What registers read and do, state by state: accesses that images/script.c executes in turn."""

import itertools
import json
import unittest

from harness import RESULT_ADDRESS, Session, SimTest, differences, image, read_edges

BOARDS = ("uno", "mega")
SCRIPT = 0x400
END, COUNT = 62, 63  # of RESULT
PIECE = 64  # bytes of a poke

# Data addresses, the same on all parts.
SREG = 0x5F
TIFR1, TIMSK1, GTCCR = 0x36, 0x6F, 0x43
TCCR1A, TCCR1B, TCCR1C = 0x80, 0x81, 0x82
TCNT1L, TCNT1H, ICR1L, ICR1H = 0x84, 0x85, 0x86, 0x87
OCR1AL, OCR1AH, OCR1BL, OCR1BH = 0x88, 0x89, 0x8A, 0x8B
OCR1CL, OCR1CH = 0x8C, 0x8D  # of the Mega: out of the way
UCSR0A, UCSR0B, UCSR0C, UBRR0L, UBRR0H, UDR0 = 0xC0, 0xC1, 0xC2, 0xC4, 0xC5, 0xC6
EECR, EEDR, EEARL, EEARH = 0x3F, 0x40, 0x41, 0x42
WDTCSR, MCUSR = 0x60, 0x54
EIFR, EIMSK, EICRA = 0x3C, 0x3D, 0x69
ACSR, ADCSRB, ADMUX = 0x50, 0x7B, 0x7C

I_BIT = 0x80
RXC, TXC, UDRE, FE, DOR, UPE, U2X = 0x80, 0x40, 0x20, 0x10, 0x08, 0x04, 0x02
RXCIE, TXCIE, UDRIE, RXEN, TXEN = 0x80, 0x40, 0x20, 0x10, 0x08
ICF, OCFB, OCFA, TOV = 0x20, 4, 2, 1
EERIE, EEMPE, EEPE, EERE = 8, 4, 2, 1
WDIF, WDIE, WDCE, WDE = 0x80, 0x40, 0x10, 0x08
FRAME = 11 * 136
UART_8E1 = ((UBRR0L, 16), (UCSR0A, U2X), (UCSR0C, 0x26))
LAST_HIGH = {"uno": 0x03, "mega": 0x0F}  # of EEAR
EXTINT = {"uno": ("D 2", 0, 2), "mega": ("D 3", 3, 0x80)}  # pin, line, sense of a fall
ICP1 = {"uno": "B 0", "mega": "D 4"}


def write(address, value):
    return bytes((1, address, 0, value))


def writes(*pairs):
    return b"".join(write(address, value) for address, value in pairs)


def read(*addresses):
    return b"".join(bytes((2, address, 0, 0)) for address in addresses)


def wait(cycles):
    """At least so many cycles, and not many more."""
    turns = cycles // 16 + 1
    return bytes((3, turns & 0xFF, turns >> 8, 0))


def after(to, value, cycles, address):
    """Write, and read so many cycles later, 4 at least."""
    return bytes((4, to, 0, value, 2, address, 0, cycles - 4))


def twice(address, first, second):
    """Two writes by instructions that follow one another: the second two cycles later."""
    return bytes((5, address, 0, first, 0, 0, 0, second))


class Script(SimTest):
    """Runs a script on each board."""

    def begin(self, board, *parts, options=()):
        sim = Session(image(board, "script"), options=options)
        self.addCleanup(sim.__exit__)
        text = b"".join(parts) + bytes(4)
        for at in range(0, len(text), PIECE):
            self.assertEqual(sim.ask(f"poke 0 {SCRIPT + at} {text[at : at + PIECE].hex()}"), "ok")
        self.assertEqual(sim.ask(f"poke 0 {RESULT_ADDRESS + 2 * END} 00000000"), "ok")
        return sim

    def results(self, sim, count):
        seen = sim.results(64)
        self.assertEqual(seen[END], 0x600D)
        return seen[:count], seen[COUNT]

    def go(self, board, *parts, count=0, cycles=60_000, commands=()):
        """What was read, and how many interrupts came."""
        sim = self.begin(board, *parts)
        for command in commands:
            self.assertTrue(sim.ask(command).startswith("ok"), command)
        self.assertEqual(sim.run(cycles), f"ok {cycles}")
        return self.results(sim, count)

    def each(self, wanted, interrupts, *parts, cycles=60_000):
        """The same on each board."""
        for board in BOARDS:
            with self.subTest(board=board):
                seen = self.go(board, *parts, count=len(wanted), cycles=cycles)
                self.assertEqual(seen, (list(wanted), interrupts))


class Uart(Script):
    def test_after_a_reset(self):
        self.each([UDRE, 0, 6, 0, 0, 0], 0, read(UCSR0A, UCSR0B, UCSR0C, UBRR0L, UBRR0H, UDR0))

    def test_txc_is_cleared_by_a_one_and_by_nothing_else(self):
        self.each(
            [UDRE | U2X, TXC | UDRE | U2X, TXC | UDRE | U2X, TXC | UDRE, UDRE | U2X],
            0,
            writes(*UART_8E1, (UCSR0B, TXEN)),
            read(UCSR0A),
            write(UDR0, 0x55),
            wait(FRAME),
            read(UCSR0A),
            write(UCSR0A, U2X),
            read(UCSR0A),
            write(UCSR0A, 0),
            read(UCSR0A),
            write(UCSR0A, TXC | U2X),
            read(UCSR0A),
        )

    def test_a_frames_end_interrupts_once(self):
        sent = (write(UDR0, 0x55), wait(FRAME + 100))
        on = writes(*UART_8E1, (UCSR0B, TXEN | TXCIE), (SREG, I_BIT))
        # Not before a frame has been sent; the handler takes the flag.
        self.each([UDRE | U2X], 0, on, wait(2000), read(UCSR0A))
        self.each([UDRE | U2X], 1, on, *sent, wait(2000), read(UCSR0A))
        self.each([], 2, on, *sent, *sent)

    def test_a_frames_end_that_is_disabled_while_it_waits(self):
        for last, interrupts, status in ((TXEN, 0, TXC), (TXEN | TXCIE, 1, 0)):
            self.check_disabled(last, interrupts, status)

    def check_disabled(self, last, interrupts, status):
        self.each(
            [status | UDRE | U2X],
            interrupts,
            writes(*UART_8E1, (UCSR0B, TXEN | TXCIE), (UDR0, 0x55)),
            wait(FRAME + 100),
            writes((UCSR0B, last), (SREG, I_BIT)),
            wait(100),
            read(UCSR0A),
        )

    def test_an_empty_register_interrupts_while_enabled(self):
        on = writes(*UART_8E1, (UCSR0B, TXEN | UDRIE))
        self.each([], 5, on, write(SREG, I_BIT), wait(500))
        self.each([], 0, on, writes((UCSR0B, TXEN), (SREG, I_BIT)), wait(500))
        # Two frames: one on its way, one that waits.
        full = writes((UDR0, 1), (UDR0, 2))
        self.each([U2X], 0, on, full, write(SREG, I_BIT), wait(500), write(SREG, 0), read(UCSR0A))
        self.each([], 5, on, full, write(SREG, I_BIT), wait(FRAME + 500))

    def test_a_third_character_is_lost(self):
        for board in BOARDS:
            log = self.folder / f"{board}.csv"
            sim = self.begin(
                board,
                writes(*UART_8E1, (UCSR0B, TXEN), (UDR0, 1), (UDR0, 2), (UDR0, 3)),
                wait(FRAME + 100),
                write(UDR0, 4),
                options=["--serial-log", str(log)],
            )
            sim.run(20_000)
            sim.ask("flush")
            rows = [row.split(",") for row in log.read_text().split()[1:]]
            self.assertEqual([row[2] for row in rows], ["01", "02", "04"])
            starts = [int(row[0]) for row in rows]
            self.assertEqual(differences(starts), [FRAME] * 2)

    def test_the_divisor_has_twelve_bits(self):
        """TXC comes 11 bits of (divisor + 1) * 8 cycles after the start bit."""
        for high, divisor in ((0xF0, 16), (1, 256 + 16)):
            frame = 11 * 8 * (divisor + 1)
            on = writes(*UART_8E1, (UBRR0H, high), (UCSR0B, TXEN), (UDR0, 0x55))
            self.each([U2X | UDRE, U2X | UDRE | TXC], 0, on, wait(frame - 100 - frame // 60),
                      read(UCSR0A), wait(200 + frame // 30), read(UCSR0A))  # fmt: skip

    def receive(self, board, *parts, count, sent="3132"):
        sim = self.begin(board, writes(*UART_8E1, (UCSR0B, RXEN)), wait(8000), *parts)
        sim.run(1000)
        self.assertTrue(sim.ask(f"send {sent}").startswith("ok"))
        sim.run(60_000)
        return self.results(sim, count)

    def test_characters_and_their_status(self):
        for board in BOARDS:
            seen = self.receive(board, read(UCSR0A, UDR0, UCSR0A, UDR0, UCSR0A, UDR0), count=6)
            full = RXC | UDRE | U2X
            self.assertEqual(seen[0], [full, 0x31, full, 0x32, UDRE | U2X, 0x32])

    def test_an_overrun_lasts_until_a_character_is_read(self):
        for board in BOARDS:
            parts = read(UCSR0A, UCSR0A, UDR0, UCSR0A, UDR0, UDR0, UCSR0A)
            seen = self.receive(board, parts, count=7, sent="31323334")
            full = RXC | UDRE | U2X
            self.assertEqual(seen[0], [full | DOR, full | DOR, 0x31, full, 0x32, 0x34, UDRE | U2X])

    def test_a_receiver_that_is_switched_off_forgets(self):
        for board in BOARDS:
            parts = (writes((UCSR0B, 0), (UCSR0B, RXEN)), read(UCSR0A))
            seen = self.receive(board, *parts, count=1, sent="31323334")
            self.assertEqual(seen[0], [UDRE | U2X])

    def test_a_character_interrupts_while_it_waits(self):
        for board in BOARDS:
            for enabled, more, interrupts in (
                (RXEN | RXCIE, b"", 5),
                (RXEN, b"", 0),
                (RXEN | RXCIE, read(UDR0, UDR0), 0),
                (RXEN | RXCIE, read(UDR0), 5),
                (RXEN | RXCIE, write(UCSR0B, RXEN), 0),
            ):
                parts = (write(UCSR0B, enabled), more, write(SREG, I_BIT), wait(500))
                self.assertEqual(self.receive(board, *parts, count=0)[1], interrupts)

    def test_what_is_not_modelled(self):
        for register, value, text in (
            (UCSR0A, 1, "UART 0: multi-processor mode is not modelled"),
            (UCSR0B, 4, "UART 0: 9 data bits are not modelled"),
            (UCSR0C, 0x46, "UART 0: synchronous modes are not modelled"),
            (UCSR0C, 0x86, "UART 0: synchronous modes are not modelled"),
        ):
            sim = self.begin("uno", write(register, value))
            self.assertIn(text, sim.run(10_000))


class Timer(Script):
    COUNTING = ((TCCR1B, 1),)

    def test_after_a_reset(self):
        registers = (TCCR1A, TCCR1B, TCCR1C, TCNT1L, ICR1L, OCR1AL, OCR1BL, TIFR1, TIMSK1)
        self.each([0] * 9, 0, read(*registers))

    def test_registers_that_read_as_zero(self):
        self.each(
            [0, 0, 0, 0],
            0,
            writes((TCCR1C, 0x1F), (ICR1H, 0x12), (ICR1L, 0x34), (GTCCR, 1)),
            read(TCCR1C, ICR1L, ICR1H, GTCCR),
        )

    def test_gtccr_keeps_what_it_has(self):
        self.each([0x83, 0x81, 0], 0, write(GTCCR, 0xFF), read(GTCCR), write(GTCCR, 0x81),
                  read(GTCCR), write(GTCCR, 0x03), read(GTCCR))  # fmt: skip

    def test_a_held_timer_stands_and_goes_on(self):
        reading = read(TCNT1L, TCNT1H)
        for board in BOARDS:
            (first, high, second, _, third, _), _ = self.go(
                board,
                writes(*self.COUNTING, (TCNT1H, 0x12), (TCNT1L, 0), (GTCCR, 0x81)),
                reading, wait(500), reading, write(GTCCR, 0), reading, count=6,
            )  # fmt: skip
            self.assertEqual((high, second), (0x12, first))
            self.assertIn((third - second) & 0xFF, range(2, 60))

    def test_flags_of_normal_mode(self):
        """Each comes with its own count; a one clears a flag, a zero none."""
        compare = ((OCR1AH, 2), (OCR1AL, 0), (OCR1BH, 4), (OCR1BL, 0), (OCR1CH, 0xA0), (OCR1CL, 0))
        self.each(
            [0, OCFA, OCFA | OCFB, OCFA | OCFB, OCFB, TOV | OCFB, OCFB],
            0,
            writes(*compare, (TCNT1H, 0), (TCNT1L, 0), *self.COUNTING),
            read(TIFR1),
            wait(0x200 + 50),
            read(TIFR1),
            wait(0x200),
            read(TIFR1),
            write(TIFR1, 0),
            read(TIFR1),
            write(TIFR1, OCFA),
            read(TIFR1),
            writes((TCNT1H, 0xFF), (TCNT1L, 0xF0)),
            wait(60),
            read(TIFR1),
            write(TIFR1, TOV),
            read(TIFR1),
        )

    def test_each_flag_interrupts_if_it_is_enabled(self):
        """Before its flag, while it waits, and no longer when it is disabled or cleared."""
        compare = (
            (OCR1AH, 0),
            (OCR1AL, 200),
            (OCR1BH, 1),
            (OCR1BL, 0),
            (OCR1CH, 0xA0),
            (OCR1CL, 0),
        )
        begin = writes(*compare, (TCNT1H, 0xFF), (TCNT1L, 0x80), *self.COUNTING)
        for flag in (TOV, OCFA, OCFB):
            others = (TOV | OCFA | OCFB) & ~flag
            enable, off = write(TIMSK1, flag), write(TIMSK1, 0)
            on = write(SREG, I_BIT)
            for parts, left, interrupts in (
                ((enable, on, begin, wait(600)), others, 1),
                ((begin, wait(600), enable, on, wait(50)), others, 1),
                ((enable, begin, wait(600), off, on, wait(50)), others | flag, 0),
                ((enable, begin, wait(600), write(TIFR1, flag), on, wait(50)), others, 0),
                ((enable, begin, wait(600), write(TIFR1, others), on, wait(50)), 0, 1),
                ((enable, begin, wait(600), off, enable, on, wait(50)), others, 1),
            ):
                self.each([left], interrupts, *parts, read(TIFR1))

    def test_a_capture_interrupts_if_it_is_enabled(self):
        far = [(register, 0xF0) for register in (OCR1AH, OCR1AL, OCR1BH, OCR1BL, OCR1CH, OCR1CL)]
        begin = writes(*far, (TCCR1B, 0x41))
        for parts, left, interrupts in (
            ((write(TIMSK1, ICF), write(SREG, I_BIT), wait(8000)), 0, 1),
            ((wait(8000), write(TIMSK1, ICF), write(SREG, I_BIT), wait(50)), 0, 1),
            ((write(TIMSK1, ICF), wait(8000), write(TIMSK1, 0), write(SREG, I_BIT)), ICF, 0),
            ((write(TIMSK1, ICF), wait(8000), write(TIFR1, ICF), write(SREG, I_BIT)), 0, 0),
        ):
            for board in BOARDS:
                pulse = [f"pin 0 {ICP1[board]} 1 at 5000"]
                seen = self.go(board, begin, *parts, wait(50), read(TIFR1), count=1, commands=pulse)
                self.assertEqual(seen, ([left], interrupts))

    def capture(self, board, control, levels):
        """TCNT at the last capture, from the first level's cycle on; None without one."""
        commands = [f"pin 0 {ICP1[board]} {level} at {cycle}" for cycle, level in levels]
        (flags, low, high), _ = self.go(
            board, writes((TCCR1B, control | 1)), wait(12_000), read(TIFR1, ICR1L, ICR1H),
            count=3, commands=commands, cycles=40_000,
        )  # fmt: skip
        return high << 8 | low if flags & ICF else None

    def test_which_levels_the_canceler_lets_through(self):
        """A level counts when it has lasted four cycles, and its edge if the level before did."""
        rising, falling, canceler = 0x40, 0, 0x80
        for board in BOARDS:
            origin = self.capture(board, rising, [(5000, 1)]) - 5003
            low = [(3000, 1), (4000, 0)]  # a level of each kind first
            high = [(2500, 1), (3000, 0), (4000, 1)]
            for name, control, levels, at in (
                ("plain rise", rising, [*low, (5000, 1)], 5003),
                ("plain fall", falling, [*high, (5000, 0)], 5003),
                ("short rise", rising, [*low, (5000, 1), (5001, 0)], 5003),
                ("long rise", rising | canceler, [*low, (5000, 1)], 5007),
                ("long fall", falling | canceler, [*high, (5000, 0)], 5007),
                ("just long", rising | canceler, [*low, (5000, 1), (5004, 0)], 5007),
                ("noise", rising | canceler, [*low, (5000, 1), (5003, 0)], 3007),
                ("noise low", falling | canceler, [*high, (5000, 0), (5003, 1)], 3007),
                ("noise, then a level", rising | canceler,
                 [*low, (5000, 1), (5002, 0), (5004, 1)], 5011),
                ("noise in a high level", rising | canceler,
                 [*high, (5000, 0), (5002, 1)], 4007),
                ("twice noise in a high level", rising | canceler,
                 [*high, (5000, 0), (5002, 1), (5004, 0), (5006, 1)], 4007),
                ("a fall after noise", falling | canceler,
                 [*high, (5000, 0), (5002, 1), (5004, 0)], 5011),
                ("a rise after a short low", rising | canceler,
                 [*high, (5000, 0), (5004, 1)], 5011),
            ):  # fmt: skip
                with self.subTest(board=board, what=name):
                    self.assertEqual(self.capture(board, control, levels), origin + at)

    def test_what_is_not_modelled(self):
        modes = range(1, 15)
        cases = [
            ((OCR1AL, 100), (TCCR1A, mode & 3), (TCCR1B, (mode & 12) << 1 | 1)) for mode in modes
        ]
        texts = [f"timer 1: waveform mode {mode} is not modelled" for mode in modes]
        for clock in range(2, 8):
            cases.append(((TCCR1B, clock),))
            texts.append(f"timer 1: clock select {clock} is not modelled")
        for com, name in ((0x40, "COM1A = 1"), (0x80, "COM1A = 2"), (0x30, "COM1B = 3")):
            cases.append(((TCCR1A, com), (TCCR1B, 1)))
            texts.append(f"timer 1: {name} in waveform mode 0 is not modelled")
        for force in (0x80, 0x40):
            cases.append(((TCCR1C, force),))
            texts.append("timer 1: force compare is not modelled")
        for pairs, text in zip(cases, texts, strict=True):
            with self.subTest(text=text):
                self.assertIn(text, self.begin("uno", writes(*pairs)).run(10_000))

    def test_a_mode_that_does_not_count_is_not_refused(self):
        self.each([2, 0x18], 0, writes((TCCR1A, 2), (TCCR1B, 0x18)), read(TCCR1A, TCCR1B))

    def test_tcnt_written_at_rest_stays(self):
        self.each([0x34, 0x12, 0x34], 0, writes((TCNT1H, 0x12), (TCNT1L, 0x34)),
                  read(TCNT1L, TCNT1H), wait(100), read(TCNT1L))  # fmt: skip


class Output(Script):
    """OC1B, the Uno's STEP pin (PB2), in mode 15 with TOP = 999."""

    def edges(self, com):
        path = self.folder / "edges.csv"
        path.unlink(missing_ok=True)
        sim = self.begin(
            "uno",
            writes((0x24, 4), (OCR1AH, 3), (OCR1AL, 0xE7), (OCR1BH, 0), (OCR1BL, 99)),
            writes((TCCR1A, com << 4 | 3), (TCCR1B, 0x19)),
            options=["--edges", str(path)],
        )
        sim.run(12_000)
        sim.ask("flush")
        return [(row[0], row[4]) for row in read_edges(path) if row[3] == "STEP"]

    def test_clear_and_set_at_a_match(self):
        for com, match_level in ((2, 0), (3, 1)):
            edges = self.edges(com)[4:]
            self.assertGreater(len(edges), 8)
            for (cycle, level), (following, other) in itertools.pairwise(edges):
                self.assertEqual(other, 1 - level)
                # From BOTTOM to the match's effect 100, from there to BOTTOM 900.
                self.assertEqual(following - cycle, 900 if level == match_level else 100)

    def test_a_disconnected_output_is_still(self):
        self.assertEqual(self.edges(0), [])


class Eeprom(Script):
    def test_addresses_end_with_the_memory(self):
        for board in BOARDS:
            seen = self.go(board, writes((EEARH, 0xFF), (EEARL, 0xFF)), read(EEARH, EEARL), count=2)
            self.assertEqual(seen[0], [LAST_HIGH[board], 0xFF])

    def test_what_the_control_register_reads(self):
        self.each([0, 0x38, 0x38, 0x30, 0], 0, read(EECR), write(EECR, 0xF8), read(EECR),
                  write(EECR, 0x38), read(EECR), write(EECR, 0x30), read(EECR),
                  write(EECR, 0), read(EECR))  # fmt: skip

    def test_the_enable_lasts_four_cycles(self):
        for cycles, seen in ((4, EEMPE), (5, 0), (6, 0)):
            self.each([seen], 0, after(EECR, EEMPE, cycles, EECR))

    def test_ready_interrupts_while_it_is_enabled(self):
        self.each([], 5, writes((EECR, EERIE), (SREG, I_BIT)), wait(300))
        self.each([], 0, writes((EECR, EERIE), (EECR, 0), (SREG, I_BIT)), wait(300))
        self.each([], 0, writes((EECR, 0), (SREG, I_BIT)), wait(300))


class Watchdog(Script):
    SHORTEST = 256_000

    def test_after_a_power_up(self):
        self.each([0, 1], 0, read(WDTCSR, MCUSR))

    def test_interrupts_that_nobody_serves_reset_nothing(self):
        """With WDIE alone, the flag of one time-out and those after it."""
        cycles = 4 * self.SHORTEST
        for board in BOARDS:
            seen = self.go(
                board, write(WDTCSR, WDIE), wait(600_000), read(WDTCSR, MCUSR), wait(300_000),
                read(WDTCSR), count=3, cycles=cycles,
            )  # fmt: skip
            self.assertEqual(seen, ([WDIF | WDIE, 1, WDIF | WDIE], 0))

    def test_the_handler_takes_the_flag_and_leaves_wdie(self):
        for board in BOARDS:
            seen = self.go(board, writes((WDTCSR, WDIE), (SREG, I_BIT)), wait(400_000),
                           read(WDTCSR), count=1, cycles=500_000)  # fmt: skip
            self.assertEqual(seen, ([WDIE], 1))

    def test_with_wde_the_handler_takes_wdie_too(self):
        for board in BOARDS:
            seen = self.go(board, writes((WDTCSR, WDIE | WDE), (SREG, I_BIT)), wait(300_000),
                           read(WDTCSR), count=1, cycles=450_000)  # fmt: skip
            self.assertEqual(seen, ([WDE], 1))

    def test_a_request_that_is_disabled_while_it_waits(self):
        for board in BOARDS:
            seen = self.go(board, write(WDTCSR, WDIE), wait(300_000),
                           writes((WDTCSR, 0), (SREG, I_BIT)), wait(100), read(WDTCSR),
                           writes((WDTCSR, WDIE)), wait(100), read(WDTCSR),
                           count=2, cycles=400_000)  # fmt: skip
            self.assertEqual(seen, ([WDIF, WDIE], 1))

    def test_the_time_needs_the_sequence(self):
        """WDP and a cleared WDE only within four cycles of WDCE and WDE together."""
        for opening, then, left in (
            (WDCE | WDE, 0x21, 0x21),
            (WDCE | WDE, WDE | 2, WDE | 2),
            (WDCE | WDE, WDCE | 0x21, WDE),
            (WDE, 0x21, WDE),
            (WDCE, 0x21, 0),
            (WDCE, WDE | 1, WDE),
        ):
            for board in BOARDS:
                seen = self.go(board, twice(WDTCSR, opening, then), read(WDTCSR), count=1)
                self.assertEqual(seen[0], [left], (opening, then))


class ExternalInterrupt(Script):
    def test_a_request_waits_for_its_enable(self):
        for board in BOARDS:
            pin, line, sense = EXTINT[board]
            mask = 1 << line
            begin = writes((EICRA, sense), (EIFR, mask))
            for parts, left, interrupts in (
                ((wait(9000), write(SREG, I_BIT), wait(50)), mask, 0),
                ((write(EIMSK, mask), wait(9000), write(SREG, I_BIT), wait(50)), 0, 1),
                ((wait(9000), write(EIMSK, mask), write(SREG, I_BIT), wait(50)), 0, 1),
                ((write(EIMSK, mask), wait(9000), writes((EIMSK, 0), (SREG, I_BIT))), mask, 0),
                ((write(EIMSK, mask), wait(9000), writes((EIFR, mask), (SREG, I_BIT))), 0, 0),
                ((write(EIMSK, mask), wait(9000), writes((EIFR, 0xFF & ~mask), (SREG, I_BIT)),
                  wait(50)), 0, 1),
            ):  # fmt: skip
                commands = [f"pin 0 {pin} 1", f"pin 0 {pin} 0 at 6000"]
                seen = self.go(board, begin, *parts, read(EIFR), count=1, commands=commands)
                self.assertEqual(seen, ([left], interrupts))


class Names(Script):
    """Each handler in the statistics has the data sheet's name of its vector."""

    def names(self, board, *parts, cycles=60_000, commands=()):
        sim = self.begin(board, *parts)
        for command in commands:
            self.assertTrue(sim.ask(command).startswith("ok"), command)
        sim.run(cycles)
        return [one["name"] for one in json.loads(sim.ask("stats"))["boards"][0]["handlers"]]

    def test_each(self):
        on = write(SREG, I_BIT)
        far = writes((OCR1CH, 0xA0), (OCR1CL, 0))
        for board in BOARDS:
            pin, line, sense = EXTINT[board]
            for parts, name in (
                (
                    (far, writes((TCNT1H, 0xFF), (TCNT1L, 0), (TCCR1B, 1), (TIMSK1, TOV))),
                    "TIMER1_OVF",
                ),
                (
                    (
                        far,
                        writes(
                            (OCR1AL, 200), (OCR1BH, 0xA0), (OCR1BL, 0), (TCCR1B, 1), (TIMSK1, OCFA)
                        ),
                    ),
                    "TIMER1_COMPA",
                ),
                ((far, writes((OCR1BL, 200), (TCCR1B, 1), (TIMSK1, OCFB))), "TIMER1_COMPB"),
                ((far, writes((TCCR1B, 0x41), (TIMSK1, ICF))), "TIMER1_CAPT"),
                ((writes(*UART_8E1, (UCSR0B, TXEN | UDRIE)),), "USART0_UDRE"),
                ((writes(*UART_8E1, (UCSR0B, TXEN | TXCIE), (UDR0, 1)),), "USART0_TX"),
                ((writes(*UART_8E1, (UCSR0B, RXEN | RXCIE)),), "USART0_RX"),
                ((write(EECR, EERIE),), "EE_READY"),
                ((writes((EICRA, sense), (EIFR, 1 << line), (EIMSK, 1 << line)),), f"INT{line}"),
            ):
                commands = [f"pin 0 {pin} 1", f"pin 0 {pin} 0 at 6000",
                            f"pin 0 {ICP1[board]} 1 at 6000", "send 55"]  # fmt: skip
                seen = self.names(board, *parts, on, wait(8000), commands=commands)
                self.assertEqual(seen, [name])
            parts = (write(WDTCSR, WDIE), on, wait(300_000))
            self.assertEqual(self.names(board, *parts, cycles=300_000), ["WDT"])


if __name__ == "__main__":
    unittest.main()
