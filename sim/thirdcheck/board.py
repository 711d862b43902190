# SPDX-License-Identifier: MIT
"""An Arduino Uno in yasimavr 0.1.6: an ATmega328P written apart from pixstep's own models.

What yasimavr has wrong or lacks, and is put right here (docs/TESTING.md says how each was seen):

* fast PWM mode 15 never clears OC1B: at TOP only channel A is looked at, since OCR1A is TOP. One
  entry of its table is changed, to clear at BOTTOM: one cycle late, so falls are not compared;
* an interrupt response of no cycles: the part takes 4;
* its run loop executes an instruction before the events that were due: a flag set meanwhile is
  lost when the instruction reads TIFRn. The loop here does the events first;
* a signal comes at the end of an instruction: edges are placed by the timer's own count;
* a capture takes the count at the end of an instruction, and hangs on no pin: it is taken here, at
  its own cycle;
* choosing an input of the comparator ends the whole process: left out, with everything else that
  the firmware does not need for a line.

Left as they are: no GTCCR (TSM), ICES1 reads as 0, timer outputs reach no pin, SBI on a flag
register clears all its flags, the cycles at which replies begin.
"""

from collections.abc import Iterable
from pathlib import Path

from yasimavr.device_library.builders._builders_arch_avr import AVR_BaseDevice, AVR_DeviceBuilder
from yasimavr.device_library.descriptors import DeviceDescriptor
from yasimavr.lib import arch_avr, core

CLOCK_HZ = 16_000_000
RESPONSE_CYCLES = 4
# From an edge on ICP1 to ICR1 (2.5 to 3.5 cycles by the data sheet), and one to the next count.
CAPTURE_CYCLES = 3 + 1
# A character of 11 bits at 17 times 8 cycles, which yasimavr takes from a byte's push to its flag.
CHARACTER_CYCLES = 11 * 17 * 8
# A byte is there when the instruction that runs is over.
INSTRUCTION_CYCLES = 5 + RESPONSE_CYCLES

TCNT1L = 0x64
TCNT1H = 0x65

# Of the table of timer 1: in modes 14 and 15, what the setting "inverting" does, by nibbles from
# the lowest: match counting up, match counting down, TOP, BOTTOM (2 clears, 3 sets).
FAST_PWM = 2
INVERTING = 0b11
CLEAR_AT_TOP = 0x0203
CLEAR_AT_BOTTOM = 0x2003

PARTS = "CPUINT RSTCTRL SLPCTRL FUSES NVMCTRL MISC PORTB PORTC PORTD EXTINT TC0 TC1 TC2 USART WDT"
# Pulled up by the board, or idle: the serial line.
HIGH_PINS = ("PB1", "PC0", "PD0", "PD2", "PD7")


class _Part(AVR_BaseDevice):
    def __init__(self, descriptor, builder):
        super().__init__(descriptor, builder)
        builder.build_peripherals(self, PARTS.split())

    def arch_init(self):
        self._builder_.add_pin_driver_mux_configs(self, "USART")
        return True


def _part():
    descriptor = DeviceDescriptor.create_from_model("atmega328p")
    modes = descriptor.peripherals["TC1"].class_descriptor.config["com_modes"]
    if modes[FAST_PWM][INVERTING] != CLEAR_AT_TOP:
        raise ValueError("another yasimavr than 0.1.6: the table of timer 1 is not the known one")
    modes[FAST_PWM][INVERTING] = CLEAR_AT_BOTTOM
    return AVR_DeviceBuilder.build_device(descriptor, _Part)


class Uno:
    """The board: `rises` of STEP (cycles), `changes` of other outputs, `sent` (cycle, byte)."""

    def __init__(self, image: Path, outputs: dict[str, str]):
        """Load the image; `outputs` are the pins to watch by signal, as {"DIR": "PD4"}."""
        self.rises: list[int] = []
        self.changes: list[str] = []
        self.sent: list[tuple[int, int]] = []
        self.late_captures = 0
        self._rising: list[int] = []  # TCNT1 at rises that are not placed yet
        self._due: list[int] = []
        self._hooks = []
        self._device = _part()
        self._loop = core.SimLoop(self._device)
        self._cycles = self._loop.cycle_manager()
        firmware = core.Firmware.read_elf(str(image))
        firmware.frequency = CLOCK_HZ
        self._device.load_firmware(firmware)
        # The analog registers, which are left out: written without effect.
        self._device.set_option(core.Device.Option.IgnoreBadCpuIO, True)
        self._probe = core.DeviceDebugProbe(self._device)
        self._connect(outputs)

    def _connect(self, outputs: dict[str, str]) -> None:
        timer = core.IOCTL_TIMER("_", "1")
        self._hook(self._signal(timer), self._output)
        self._hook(self._signal(core.IOCTL_UART("0")), self._serial)
        self._hook(self._signal(core.IOCTL_INTR), self._interrupt)
        _, request = self._device.ctlreq(timer, arch_avr.CTLREQ_TMR_GET_CAPT_HOOK)
        self._capture_hook = request.data.value(core.SignalHook)
        for name in HIGH_PINS:
            self._device.find_pin(name).set_external_state("H")
        for signal, name in outputs.items():
            self._hook(self._device.find_pin(name).signal(), self._watcher(signal))

    def play(self, clock: Iterable[int], received: Iterable[tuple[int, int]], end: int) -> None:
        """Run to the cycle `end`, with rising edges of the pixel clock and (cycle, byte)."""
        edges = [(cycle + CAPTURE_CYCLES, self._capture, cycle) for cycle in clock]
        pushes = [(cycle - CHARACTER_CYCLES, self._receive, byte) for cycle, byte in received]
        inputs = sorted(edges + pushes, key=lambda item: item[0], reverse=True)

        def feed(now: int) -> int:
            while inputs and inputs[-1][0] <= now:
                due, act, value = inputs.pop()
                act(due, value)
            return inputs[-1][0] if inputs else 0

        timer = core.CallableCycleTimer(feed)
        self._cycles.schedule(timer, inputs[-1][0])
        self._run(end)
        if self._due:
            raise ValueError(f"{len(self._due)} received bytes never reached the firmware")

    def _run(self, end: int) -> None:
        execute, process = self._device.exec_cycle, self._cycles.process_timers
        now, advance = self._cycles.cycle, self._cycles.increment_cycle
        while now() < end:
            advance(execute())
            process()
            if self._rising:
                self._place()
        if self._device.state() != core.Device.State.Running:
            raise ValueError(f"the part is not running at the end: {self._device.state()}")

    def _place(self) -> None:
        """Date the rises that came with the last instruction by the timer's count since."""
        self._cycles.increment_cycle(1)  # a count is that of the cycle before
        count = self._count()
        self._cycles.increment_cycle(-1)
        self.rises.extend(self._cycles.cycle() - (count - at) for at in self._rising)
        self._rising.clear()

    def _count(self) -> int:
        peek = self._probe.read_ioreg
        return peek(TCNT1L, False) | peek(TCNT1H, False) << 8

    def _capture(self, due: int, _) -> None:
        """Take the capture at the cycle it is due, some cycles ago."""
        back = self._cycles.cycle() - due
        self._cycles.increment_cycle(-back)
        self._capture_hook.raised(core.signal_data_t(), 0)
        taken = self._count()
        self._cycles.increment_cycle(back)
        # Where the timer had counted on already, its count cannot be taken back.
        self.late_captures += self._count() - taken != back

    def _receive(self, due: int, byte: int) -> None:
        request = core.ctlreq_data_t()
        request.data = core.vardata_t(bytes((byte,)))
        self._device.ctlreq(core.IOCTL_UART("0"), core.CTLREQ_USART_BYTES, request)
        self._due.append(due + CHARACTER_CYCLES)

    def _signal(self, peripheral):
        _, request = self._device.ctlreq(peripheral, core.CTLREQ_GET_SIGNAL)
        return request.data.value(core.Signal)

    def _hook(self, signal, function) -> None:
        hook = core.CallableSignalHook(function)
        self._hooks.append(hook)
        signal.connect(hook)

    def _output(self, data, _) -> None:
        changed = data.sigid == arch_avr.ArchAVR_Timer.SignalId.CompOutput and data.index == 1
        if changed and data.data.value():
            self._rising.append(self._count())

    def _interrupt(self, data, _) -> None:
        if data.data.value() == core.InterruptController.State.Acknowledged:
            self._cycles.increment_cycle(RESPONSE_CYCLES)

    def _serial(self, data, _) -> None:
        cycle = self._cycles.cycle()
        if data.sigid == core.UART.SignalId.TX_Start:
            self.sent.append((cycle, data.data.value()))
        elif data.sigid == core.UART.SignalId.RX_Complete:
            late = cycle - self._due.pop(0)
            if not data.data.value() or not 0 <= late <= INSTRUCTION_CYCLES:
                raise ValueError(f"cycle {cycle}: a byte is {late} cycles late, or refused")

    def _watcher(self, signal: str):
        def changed(data, _) -> None:
            if data.sigid == core.Wire.SignalId.DigitalChange:
                self.changes.append(f"{signal} {data.data.value()} after {len(self.rises)} steps")

        return changed
