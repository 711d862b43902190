# SPDX-License-Identifier: MIT
"""The simulator's own tests find what is planted in its models: each defect below, one at a time.

    sim_plants.py BUILD [PLANT...]

BUILD is a finished build of the host preset. A defect is planted in a copy of its source, which is
compiled as the build did and linked with the objects of the rest; the suites of sim/tests run until
one fails. Not part of tools/check: it takes some fifteen minutes. `cmake --build BUILD --target
sim_plants` runs it.
"""

import os
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from common import ROOT, board_names, build_folder, finish
from planting import compile_words, link_words, swapped

MISSED_AT_MOST = 0
SUITE_SECONDS = 120
TARGET = "bin/pixstep-sim"


@dataclass(frozen=True)
class Plant:
    """A defect: what it is, and in `file` of sim/ `right` becomes `wrong`."""

    about: str
    file: str
    right: str
    wrong: str


TIMER = "timer16.c"
TIMER_REGISTERS = "timer16_registers.c"
TIMERS = "timers.c"
UART = "uart.c"
UART_REGISTERS = "uart_registers.c"
EEPROM = "eeprom.c"
WATCHDOG = "watchdog.c"
EXTINT = "extint.c"
PORTS = "ports.c"
COMPARATOR = "comparator.c"
RUN = "run_loop.c"
STATS = "irq_stats.c"
PIXEL_CLOCK = "pixel_clock.c"
PIN = "pin_flaws.c"
BENCH = "bench.c"
OUTPUTS = "outputs.c"
BUS = "bus.c"

PLANTS = (
    # Timers
    Plant("a compare output a cycle early", TIMER, "? match + 1 :", "? match :"),
    Plant(
        "a match at BOTTOM wins over BOTTOM",
        TIMER,
        "if (com != COM_PORT && cycle != t->bottom_due) {",
        "if (com != COM_PORT) {",
    ),
    Plant(
        "compare values that are not buffered",
        TIMER_REGISTERS,
        "if (!IS_PWM_MODE(timer16_mode(t))) {",
        "if (true) {",
    ),
    Plant(
        "a buffer written in the last cycle of a period counts at once",
        TIMER_REGISTERS,
        "    timer16_sync(t, cycle);\n    t->ocr_buffer[channel]",
        "    timer16_sync(t, cycle - 1);\n    t->ocr_buffer[channel]",
    ),
    Plant(
        "a flag that a zero clears",
        TIMER_REGISTERS,
        "uint8_t cleared = access_flags_written(avr, value);\n\n    timer16_sync",
        "uint8_t cleared = (uint8_t)~access_flags_written(avr, value);\n\n    timer16_sync",
    ),
    Plant(
        "a period of TOP cycles",
        TIMER,
        "t->bottom_due = t->bottom + top_of(t) + 1U;\n    raise_unless_set",
        "t->bottom_due = t->bottom + top_of(t);\n    raise_unless_set",
    ),
    Plant(
        "a capture in the cycle of BOTTOM that reads TOP + 1",
        TIMER,
        "t->icr = timer16_count(t, cycle);",
        "t->icr = cycle == t->bottom && cycle != 0 ? (uint16_t)(top_of(t) + 1U)\n"
        "                                             : timer16_count(t, cycle);",
    ),
    Plant(
        "a capture two cycles behind its edge",
        TIMER,
        "plan_capture(t, cycle + TIMER16_ICP_SYNC_CYCLES);",
        "plan_capture(t, cycle + TIMER16_ICP_SYNC_CYCLES - 1);",
    ),
    Plant(
        "a capture on the wrong edge",
        TIMER,
        "    if (level != t->icp_lasting && level == rising_wanted) {",
        "    if (level != t->icp_lasting && level != rising_wanted) {",
    ),
    Plant(
        "a noise canceler that delays nothing",
        TIMER,
        "t->capture_due = due + TIMER16_NOISE_CANCELER_CYCLES;",
        "t->capture_due = due;",
    ),
    Plant(
        "TCNT written blocks no match",
        TIMER,
        "plan_all(t, cycle + 1); // a match",
        "plan_all(t, cycle); // a match",
    ),
    Plant(
        "TCNT written at rest blocks no match",
        TIMER,
        "from += t->blocked ? 1 : 0;",
        "from += 0;",
    ),
    Plant(
        "a TEMP for each register",
        TIMER_REGISTERS,
        "    t->temp = (uint8_t)(count >> 8);\n",
        "",
    ),
    Plant(
        "a read of ICRn that leaves TEMP alone",
        TIMER_REGISTERS,
        "    t->temp = (uint8_t)(t->icr >> 8);\n",
        "",
    ),
    Plant(
        "OCRnx reads what the comparator sees",
        TIMER_REGISTERS,
        "return (uint8_t)(t->ocr_buffer[channel] >> (high ? 8 : 0));",
        "return (uint8_t)(t->ocr[channel] >> (high ? 8 : 0));",
    ),
    Plant(
        "a flag that is set in the step behind its clearing is lost",
        TIMER_REGISTERS,
        "    timer16_sync(t, access_cycle(avr));\n    avr->data[address] &= (uint8_t)~cleared;",
        "    timer16_sync(t, access_cycle(avr) + 1);\n    avr->data[address] &= (uint8_t)~cleared;",
    ),
    Plant(
        "a flag that waits is not raised when it is enabled",
        TIMER_REGISTERS,
        "} else if (avr_regbit_get(avr, vector->raised) != 0 && !vector->pending) {",
        "} else if (false) {",
    ),
    Plant(
        "timers that GTCCR does not hold",
        TIMER,
        "&& !t->held;",
        ";",
    ),
    Plant(
        "channel C's buffer counts at once",
        TIMER_REGISTERS,
        "if (!IS_PWM_MODE(timer16_mode(t))) {",
        "if (!IS_PWM_MODE(timer16_mode(t)) || channel == 2) {",
    ),
    Plant(
        "channel C's buffer is never loaded",
        TIMER,
        "        t->ocr[i] = t->ocr_buffer[i];\n        if (timer16_com",
        "        t->ocr[i] = (i == 2) ? t->ocr[i] : t->ocr_buffer[i];\n        if (timer16_com",
    ),
    Plant(
        "OCRnC reads what the comparator sees",
        TIMER_REGISTERS,
        "return (uint8_t)(t->ocr_buffer[channel] >>",
        "return (uint8_t)((channel == 2 ? t->ocr : t->ocr_buffer)[channel] >>",
    ),
    Plant(
        "a second captured edge takes the first one's place",
        TIMER,
        "        t->second_capture_due = due;",
        "        t->capture_due = due;",
    ),
    Plant(
        "a second captured edge is lost",
        TIMER,
        "        t->second_capture_due = due;",
        "        (void)due;",
    ),
    Plant(
        "normal mode that wraps a count early",
        TIMER,
        "#define COUNT_MAX          0xFFFFU",
        "#define COUNT_MAX          0xFFFEU",
    ),
    Plant(
        "ICRn read without what has happened since",
        TIMER_REGISTERS,
        "    timer16_sync(t, access_cycle(avr));\n    t->temp = (uint8_t)(t->icr >> 8);",
        "    (void)avr;\n    t->temp = (uint8_t)(t->icr >> 8);",
    ),
    Plant(
        "TCCRnA in force a cycle early",
        TIMER_REGISTERS,
        "uint64_t cycle = access_cycle(avr) + 1;\n\n    timer16_sync(t, cycle);\n"
        "    avr->data[address] = value;\n    t->tccra",
        "uint64_t cycle = access_cycle(avr);\n\n    timer16_sync(t, cycle);\n"
        "    avr->data[address] = value;\n    t->tccra",
    ),
    Plant(
        "a pin that is not told that its timer leaves it",
        TIMER_REGISTERS,
        "    timer16_control_changed(t, cycle);\n    report_outputs(t, cycle);",
        "    timer16_control_changed(t, cycle);\n    (void)report_outputs;",
    ),
    Plant(
        "TSM that holds without PSRSYNC",
        TIMERS,
        "tsm && (value & GTCCR_SYNC) != 0, cycle",
        "tsm, cycle",
    ),
    Plant(
        "a compare value written on the way interrupts late",
        TIMER,
        "    plan_match(t, channel, cycle);\n    timer16_schedule(t);",
        "    plan_match(t, channel, cycle);",
    ),
    Plant(
        "TCNT written to TOP is let pass",
        TIMER,
        "== MODE_FAST_PWM_OCRA && count >= t->ocr[0]",
        "== MODE_FAST_PWM_OCRA && count > t->ocr[0]",
    ),
    # The serial bus
    Plant(
        "an empty UDR that reads 0",
        UART_REGISTERS,
        "    if (u->fifo_count > 0) {\n        u->rx_last",
        "    u->rx_last = 0;\n    if (u->fifo_count > 0) {\n        u->rx_last",
    ),
    Plant("RXC in the middle of the stop bit", UART, "/ 8 * 6 :", "/ 8 * 4 :"),
    Plant("a frame without its parity bit", UART, "!= 0 ? 1 : 0;", "!= 0 ? 0 : 0;"),
    Plant(
        "one character buffered, not two",
        UART,
        "if (u->fifo_count == UART_FIFO) {",
        "if (u->fifo_count == UART_FIFO - 1) {",
    ),
    Plant(
        "an overrun at the end of the frame, not at its start bit",
        UART,
        "    if ((uart_ucsrb(u) & RXEN) != 0) {\n        overrun_shift_register(u);\n    }\n",
        "",
    ),
    Plant(
        "a parity error shows as a frame error",
        UART,
        "character.errors = UPE;",
        "character.errors = FE;",
    ),
    Plant(
        "a wrong rate is not noticed",
        UART,
        "if (frame->corrupted || !speed_fits(u, frame) ||",
        "if (frame->corrupted ||",
    ),
    Plant(
        "TXC before the last frame has ended",
        UART,
        "    if (u->waiting) {\n        u->waiting = false;",
        "    if (u->waiting && false) {\n        u->waiting = false;",
    ),
    Plant(
        "UDRE while a character waits",
        UART_REGISTERS,
        "(u->waiting ? 0U : UDRE)",
        "UDRE",
    ),
    Plant(
        "DOR that a read of UDR does not end",
        UART_REGISTERS,
        "        u->overrun = false;\n        uart_follow_levels(u);",
        "        uart_follow_levels(u);",
    ),
    Plant(
        "a receiver that stays full when it is switched off",
        UART_REGISTERS,
        "        u->fifo_count = 0; //",
        "        u->fifo_count += 0; //",
    ),
    Plant(
        "two stop bits that are one",
        UART,
        "(uart_ucsrc(u) & USBS) != 0 ? 2 : 1);",
        "(uart_ucsrc(u) & USBS) != 0 ? 1 : 1);",
    ),
    Plant(
        "a receiver of normal speed that samples early",
        UART,
        "/ 16 * 10;",
        "/ 16 * 8;",
    ),
    Plant(
        "the errors of the newest character",
        UART_REGISTERS,
        "u->fifo[0].errors",
        "u->fifo[u->fifo_count - 1].errors",
    ),
    Plant(
        "UDR written while the transmitter is off",
        UART_REGISTERS,
        "(uart_ucsrb(u) & TXEN) == 0 || u->waiting",
        "u->waiting",
    ),
    Plant(
        "a character written while the transmitter is off waits",
        UART_REGISTERS,
        "    if ((uart_ucsrb(u) & TXEN) == 0 || u->waiting) {\n",
        "    if ((uart_ucsrb(u) & TXEN) == 0) {\n"
        "        u->waiting = true;\n"
        "        u->waiting_data = value;\n"
        "        return;\n"
        "    }\n"
        "    if (u->waiting) {\n",
    ),
    Plant(
        "a start bit seen at its beginning",
        UART,
        "return own_time_from_bench(u->time, frame->start) + decided_cycles(u);",
        "return own_time_from_bench(u->time, frame->start);",
    ),
    Plant(
        "a driver that may cut the stop bit and more",
        UART,
        "cycle + uart_bit_cycles(u) / 2 < u->shift_end",
        "cycle + uart_bit_cycles(u) * 4 < u->shift_end",
    ),
    Plant(
        "RXC with one character only",
        UART,
        "u->fifo_count > 0, cycle);",
        "u->fifo_count == 1, cycle);",
    ),
    Plant(
        "UDRE that interrupts once",
        UART,
        "&u->part->udrc, !u->waiting, cycle);",
        "&u->part->udrc, false, cycle);",
    ),
    Plant(
        "other data bits are taken",
        UART,
        "!speed_fits(u, frame) || (other & UCSZ) != 0) {",
        "!speed_fits(u, frame)) {",
    ),
    Plant(
        "a collision over the stop bit",
        BUS,
        "return frame->end - frame->bit_cycles_x1000 / 1000;",
        "return frame->end;",
    ),
    Plant(
        "only the later frame of a collision is damaged",
        BUS,
        "other->corrupted = frame->corrupted = true;",
        "frame->corrupted = true;",
    ),
    # EEPROM
    Plant(
        "a write that needs no enable",
        EEPROM,
        "} else if ((bits & EEPE) != 0 && enabled) {",
        "} else if ((bits & EEPE) != 0) {",
    ),
    Plant(
        "an erase that writes the value",
        EEPROM,
        "        return EEPROM_ERASED;\n",
        "        return e->value;\n",
    ),
    Plant(
        "a write that sets bits",
        EEPROM,
        "return e->bytes[e->address] & e->value;",
        "return e->value;",
    ),
    Plant(
        "no halt behind EERE",
        EEPROM,
        "    e->avr->cycle += HALT_AFTER_EERE;\n",
        "",
    ),
    Plant(
        "half a write as long as a whole one",
        EEPROM,
        "? EEPROM_BOTH_US : EEPROM_HALF_US);",
        "? EEPROM_BOTH_US : EEPROM_BOTH_US);",
    ),
    Plant(
        "EE_READY while a byte is being written",
        EEPROM,
        "(e->avr->data[e->part->r_eecr] & EERIE) != 0 && !e->busy;",
        "(e->avr->data[e->part->r_eecr] & EERIE) != 0;",
    ),
    Plant(
        "a reset that loses the end of a write",
        EEPROM,
        "        e->avr->data[e->part->r_eecr] = (uint8_t)(e->mode << 4);\n"
        "        schedule_end(e);",
        "        e->avr->data[e->part->r_eecr] = (uint8_t)(e->mode << 4);",
    ),
    Plant(
        "a reset that ends a write",
        EEPROM,
        "    if (e->busy) { //",
        "    e->busy = false;\n    if (e->busy) { //",
    ),
    # Watchdog
    Plant(
        "a watchdog of half the time",
        WATCHDOG,
        "<< prescaler_bits(w));",
        "<< prescaler_bits(w)) / 2;",
    ),
    Plant(
        "WDR that restarts nothing",
        WATCHDOG,
        "    w->since = w->avr->cycle + 1;\n}",
        "    (void)w;\n}",
    ),
    Plant(
        "a change that needs no timed sequence",
        WATCHDOG,
        "    if (!may_change) {",
        "    if (!may_change && false) {",
    ),
    Plant(
        "WDRF that does not hold WDE",
        WATCHDOG,
        "return reset_flag_set(w) ? (after | WDE) : after;",
        "return after;",
    ),
    Plant(
        "a watchdog's period that begins when it is served",
        WATCHDOG,
        "        w->since = at;",
        "        w->since = w->avr->cycle;",
    ),
    Plant(
        "a watchdog's period a cycle long",
        WATCHDOG,
        "        w->since = at;",
        "        w->since = at + 1;",
    ),
    Plant(
        "a watchdog's first period that begins late",
        WATCHDOG,
        "    if (!ran) {\n        w->since = cycle + 1;",
        "    if (!ran) {\n        w->since = cycle + 9;",
    ),
    Plant(
        "WDR that counts from its beginning",
        WATCHDOG,
        "    w->since = w->avr->cycle + 1;\n}",
        "    w->since = w->avr->cycle;\n}",
    ),
    Plant(
        "WDCE that reads too short",
        WATCHDOG,
        "(access_cycle(avr) <= w->change_until ? WDCE : 0U)",
        "(access_cycle(avr) < w->change_until ? WDCE : 0U)",
    ),
    # External interrupts and the comparator
    Plant(
        "an external interrupt on the wrong edge",
        EXTINT,
        "    case ON_FALL:\n        return !rises;",
        "    case ON_FALL:\n        return rises;",
    ),
    Plant(
        "an external interrupt without its synchroniser",
        EXTINT,
        "cycle + EXTINT_SYNC_CYCLES;",
        "cycle;",
    ),
    Plant(
        "a comparator that is inverted",
        COMPARATOR,
        "bool low = c->port != '\\0' && !ports_level",
        "bool low = c->port != '\\0' && ports_level",
    ),
    Plant(
        "ACI on the wrong edge",
        COMPARATOR,
        "    case ON_RISE:\n        return rises;",
        "    case ON_RISE:\n        return !rises;",
    ),
    Plant(
        "a second edge in the synchroniser that delays the first",
        EXTINT,
        "    if (is_sensed(e, line, level) && e->line[line].flag_due == EXTINT_NEVER) {",
        "    if (is_sensed(e, line, level)) {",
    ),
    Plant(
        "a second edge in the synchroniser that takes the first back",
        EXTINT,
        "    e->line[line].level = level;\n",
        "    e->line[line].level = level;\n    e->line[line].flag_due = EXTINT_NEVER;\n",
    ),
    # Interrupts
    Plant(
        "no instruction behind a RETI that finds I set",
        RUN,
        "return !returned && avr",
        "return avr",
    ),
    Plant(
        "two instructions behind SEI",
        RUN,
        "    if (avr->interrupt_state == STATE_ONE_PASSED) {\n"
        "        avr->interrupt_state = avr_has",
        "    if (avr->interrupt_state == STATE_ONE_PASSED) {\n"
        "        avr->interrupt_state++;\n        return false;\n    }\n"
        "    if (avr->interrupt_state == 0) {\n"
        "        avr->interrupt_state = avr_has",
    ),
    Plant(
        "a response a cycle short",
        STATS,
        "? IRQ_RESPONSE_22_BIT_PC : IRQ_RESPONSE_16_BIT_PC;",
        "? IRQ_RESPONSE_22_BIT_PC - 1 : IRQ_RESPONSE_16_BIT_PC - 1;",
    ),
    Plant(
        "a wake-up that costs nothing",
        STATS,
        "        s->avr->cycle += IRQ_RESPONSE_FROM_SLEEP;\n",
        "",
    ),
    Plant(
        "a skip over ADIW that passes two words",
        RUN,
        "skips_mend(loop->image.skips, avr, avr_run_one(avr));",
        "avr_run_one(avr);",
    ),
    # Ports
    Plant(
        "a level that PINx shows at once",
        PORTS,
        "    if (p->avr->cycle > cycle) {",
        "    if (p->avr->cycle >= cycle) {",
    ),
    Plant(
        "a synchronizer of two cycles",
        PORTS,
        "#define SYNCHRONIZER_CYCLES 1",
        "#define SYNCHRONIZER_CYCLES 2",
    ),
    Plant(
        "one synchronizer for all pins",
        PORTS,
        "        avr_cycle_timer_register(p->avr, SYNCHRONIZER_CYCLES, on_synchronized, p);",
        "        avr_cycle_timer_register(\n"
        "            p->avr,\n"
        "            SYNCHRONIZER_CYCLES + (p->pins[index].arriving != mask ? 1 : 0),\n"
        "            on_synchronized,\n"
        "            p);",
    ),
    Plant(
        "an outside level over an output",
        PORTS,
        "if ((p->pins[index].ddr & mask) == 0 && (p->pins[index].driven_mask & mask) != 0) {",
        "if ((p->pins[index].driven_mask & mask) != 0) {",
    ),
    Plant(
        "PINx that is low after a reset",
        PORTS,
        "|= (uint8_t)((level ? 1U : 0U) << bit);",
        "|= (uint8_t)((level ? 0U : 0U) << bit);",
    ),
    # The pixel clock, pins of their own, oscillators
    Plant(
        "pulses that run into each other",
        PIXEL_CLOCK,
        "(int64_t)(c->last_fall + GAP_CYCLES);",
        "(int64_t)(c->last_fall - GAP_CYCLES);",
    ),
    Plant(
        "a gate that rests an edge early",
        PIXEL_CLOCK,
        "c->burst >= c->settings.gate_edges",
        "c->burst + 1 >= c->settings.gate_edges",
    ),
    Plant(
        "a rest that moves only what is not made",
        PIXEL_CLOCK,
        "        c->next.rise += cycles;\n",
        "        c->next.rise += 0;\n",
    ),
    Plant(
        "another frequency behind a pulse that was never made",
        PIXEL_CLOCK,
        "    c->last_fall = c->given_fall;\n",
        "",
    ),
    Plant(
        "a missing edge of one pin at the next one",
        PIN,
        "p->edges + nth - 1",
        "p->edges + nth",
    ),
    Plant(
        "a false edge of one pin in the middle of the period",
        PIN,
        "pulse->rise + period * flaw->phase / THOUSAND",
        "pulse->rise + period / 2",
    ),
    Plant(
        "flaws of the first pin at all pins",
        BENCH,
        "    struct pin_flaws *pin = &bench->pin[board];\n",
        "    struct pin_flaws *pin = &bench->pin[0];\n",
    ),
    Plant(
        "a pulse in the first board's time",
        BENCH,
        "    own.rise = own_time_from_bench(time, pulse->rise);",
        "    own.rise = pulse->rise;",
    ),
    Plant(
        "a frame in the sender's time",
        UART,
        ".start = own_time_to_bench(u->time, cycle),",
        ".start = cycle,",
    ),
    Plant(
        "edges in the board's time",
        OUTPUTS,
        "        .cycle = own_time_to_bench(o->time, cycle),",
        "        .cycle = cycle,",
    ),
    Plant(
        "all supplies come on together",
        BENCH,
        "        noise_seed(&random, seed, NOISE_PLACE + (unsigned)i);",
        "        noise_seed(&random, seed, NOISE_PLACE);",
    ),
)


def with_plant(build: Path, plant: Plant, folder: Path) -> Path:
    """Compile and link the simulator with a plant; return the program."""
    kept = ROOT / "sim" / plant.file
    source, made, program = folder / plant.file, folder / "plant.o", folder / "pixstep-sim"
    text = kept.read_text(encoding="utf-8")
    source.write_text(
        swapped(text, plant.right, plant.wrong, f"sim/{plant.file}"), encoding="utf-8"
    )
    words = compile_words(build, kept, TARGET)
    replaced = words[words.index("-o") + 1]
    words[words.index("-o") + 1] = str(made)
    words[words.index(str(kept))] = str(source)
    words.insert(1, f"-I{kept.parent}")
    subprocess.run(words, cwd=build, check=True)
    words = [str(made) if word == replaced else word for word in link_words(build, TARGET)]
    words[words.index(TARGET)] = str(program)
    subprocess.run(words, cwd=build, check=True)
    return program


def suites() -> list[Path]:
    """Return the simulator's suites, the quickest of the models' first."""
    first = ("interrupts", "uart", "timers", "eeprom", "watchdog", "extint", "comparator", "ports")
    named = [ROOT / "sim" / "tests" / f"test_{name}.py" for name in first]
    rest = sorted(set((ROOT / "sim" / "tests").glob("test_*.py")) - set(named))
    return named + rest


def find(program: Path) -> str:
    """Return the first suite that fails with this program; nothing when none does."""
    images = {
        f"PIXSTEP_{board.upper()}_IMAGES": str(build_folder(board) / "sim/tests/images")
        for board in board_names()
    }
    own = {"PIXSTEP_SIM": str(program), "PYTHONDONTWRITEBYTECODE": "1"}
    environment = os.environ | images | own
    for suite in suites():
        process = subprocess.Popen(
            [sys.executable, str(suite), "--failfast"],
            cwd=suite.parent,
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            process_group=0,
        )
        try:
            if process.wait(SUITE_SECONDS) != 0:
                return suite.stem
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)  # the simulators that it has begun, too
            process.wait()
            return f"{suite.stem} (no end)"
    return ""


def main() -> None:
    """Plant each defect, or those named, and run the suites."""
    build, chosen = Path(sys.argv[1]).resolve(), sys.argv[2:]
    plants = [plant for plant in PLANTS if not chosen or plant.about in chosen]
    failing = find(build / TARGET)
    if failing:
        finish("sim_plants", "no plant", [f"{failing} fails without a plant"])
    missed = []
    for plant in plants:
        with tempfile.TemporaryDirectory(prefix="pixstep-") as name:
            found = find(with_plant(build, plant, Path(name)))
        print(f"{plant.file}: {plant.about}: {found or 'NOT FOUND'}", flush=True)
        if not found:
            missed.append(f"{plant.file}: {plant.about}: not found")
    problems = missed if len(missed) > MISSED_AT_MOST else []
    finish("sim_plants", f"{len(plants)} defects planted, {len(missed)} not found", problems)


if __name__ == "__main__":
    main()
