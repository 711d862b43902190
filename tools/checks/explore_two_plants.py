# SPDX-License-Identifier: MIT
"""pixstep-explore-two finds what is planted: defects that only several axes can have.

explore_two_plants.py COMPILER WORDS SEARCH FIRMWARE [PLANT...], as explore_plants.py.
"""

from explore_plants import AXES, ENGINE_H, ESTOP, PERMIT, RUNAWAY, TIMER, Change, Plant
from explore_plants import main as plant_all

ISR_H = "firmware/avr/hal/step_isr.h"
PARKED = "firmware/avr/hal/step_parked.c"
PINS = "firmware/avr/hal/pins.c"
START = "firmware/app/motion/start.c"
STEP_ISR = "host_tests/explore/two/step_isr.c"
CAPTURE_ISR = "host_tests/explore/two/capture_isr.c"

TICK = "an edge is not at its tick"
DIRECTION = "an edge in the wrong direction"
TOGETHER = "axes do not begin on one edge of the clock"
FAULT = "a fault that nothing gave cause for"
ENDLESS = "the program does not come to an end"
WIDE = "a shared word is accessed with interrupts on"
EARLY = "an edge before the release"

# Of the searches that the tests run.
ONE = ("--actions", "1", "--periods", "1")
PINS_TOO = (*ONE, "--pins", "1")

PLANTS = (
    Plant(
        "a halt that halts every axis",
        FAULT,
        (Change(TIMER, "if (CONFIG_AXES == 1 || which == (axis)) {", "if (true) {"),),
        limits=(*ONE, "--from", "both run, moment 10"),
    ),
    Plant(
        "a stop that halts the other axis",
        FAULT,
        (Change(AXES, "    step_timer_halt(i);\n}", "    step_timer_halt(i ^ 1u);\n}"),),
        limits=(*ONE, "--from", "both run, moment 10"),
    ),
    Plant(
        "an emergency stop that halts the first axis only",
        RUNAWAY,
        (Change(ESTOP, "        step_timer_halt(i);", "        step_timer_halt(0);"),),
        limits=(*PINS_TOO, "--from", "both run, moment 10"),
    ),
    Plant(
        "a settled axis that empties the other one's ring",
        FAULT,
        (
            Change(
                TIMER,
                "&step_engines[CONFIG_INDEX(axis)], &step_rings[CONFIG_INDEX(axis)], slot)",
                "&step_engines[CONFIG_INDEX(axis)], &step_rings[axis ^ 1u], slot)",
            ),
        ),
        limits=(*ONE, "--from", "both run, moment 8"),
    ),
    Plant(
        "one base for the idle periods of both parked axes",
        FAULT,
        (
            Change(
                PARKED,
                "    parked_bases[axis] = parked_base(",
                "    parked_bases[0] = parked_bases[1] = parked_base(",
            ),
        ),
        limits=(*ONE, "--from", "loaded, moment 0"),
    ),
    Plant(
        "an axis unparked by a count that is a period old",
        FAULT,
        (
            Change(
                PARKED,
                "} while (!serve_from_here(axis));",
                "} while (false); serve_overflow(axis, true);",
            ),
        ),
        limits=("--actions", "1", "--periods", "2", "--from", "both begin by a token, moment 1"),
    ),
    Plant(
        "one count of idle periods for both axes",
        ENDLESS,
        (
            Change(
                TIMER,
                "engine->idle_count == idle_count) {",
                "step_engines[0].idle_count == idle_count) {",
            ),
        ),
        limits=(*ONE, "--from", "loaded, moment 0"),
    ),
    Plant(
        "directions of both axes written to one port with interrupts on",
        DIRECTION,
        (
            Change(
                TIMER,
                "if (load.reverses) { ATOMIC_BLOCK(ATOMIC_FORCEON) {",
                "if (load.reverses) { {",
            ),
            Change(
                PINS,
                "    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)\n    {\n        write_direction(",
                "    {\n        write_direction(",
            ),
        ),
        limits=("--actions", "1", "--periods", "2", "--from", "both run, moment 56"),
    ),
    Plant(
        "a sample that interrupts may come into",
        WIDE,
        (
            Change(
                ISR_H,
                "    ATOMIC_BLOCK(ATOMIC_FORCEON)\n    {\n        tail = engine->tail;",
                "    {\n        tail = engine->tail;",
            ),
        ),
        (TIMER,),
        limits=(*ONE, "--from", "loaded, moment 0"),
    ),
    Plant(
        "a read of the counter that leaves TEMP overwritten",
        TICK,
        (
            Change(
                TIMER,
                "counter = TCNT##timer; OCR##timer##AH = step_engines[number].train_high;",
                "counter = TCNT##timer;",
            ),
        ),
        limits=(*ONE, "--from", "loaded, moment 0"),
    ),
    Plant(
        "a capture that leaves TEMP overwritten",
        TICK,
        (
            Change(
                CAPTURE_ISR,
                "ticks = TIMER.icr;\n    TIMER.temp = ENGINE.train_high;",
                "ticks = TIMER.icr;",
            ),
        ),
        limits=(*ONE, "--from", "axis 0 locked, armed late, moment 0"),
    ),
    Plant(
        "a command that puts the other axis's mask back",
        FAULT,
        (
            Change(
                STEP_ISR,
                "    isr->timer->timsk = mask;",
                "    part_registers.timers[isr->axis ^ 1u].timsk = mask;",
            ),
        ),
        limits=(*ONE, "--from", "loaded, moment 0"),
    ),
    Plant(
        "a token that the stop of any axis takes away",
        EARLY,
        (
            Change(
                AXES,
                "if (CONFIG_AXES == 1 || !axes_any_armed()) {",
                "if (true) {",
            ),
        ),
        limits=(*ONE, "--from", "both wait for their token, moment 0"),
    ),
    Plant(
        "an axis that begins an edge of the clock after the other one",
        TOGETHER,
        (
            Change(
                START,
                "            axis_place(axis, zero);",
                "            axis_place(axis, zero + i * reference_period()->whole_ticks);",
            ),
        ),
        limits=(*ONE, "--from", "both begin on an edge, moment 0"),
    ),
    Plant(
        "an axis that is placed by one tick beside the clock",
        TICK,
        (
            Change(
                START,
                "            axis_place(axis, zero);",
                "            axis_place(axis, zero + i);",
            ),
        ),
        limits=(*ONE, "--from", "both begin on an edge, moment 0"),
    ),
    Plant(
        "a stop that drops the permit late",
        PERMIT,
        (
            Change(
                "firmware/app/registers/commands.c",
                "    permit_set(false);\n    if (state_of(i) != AXIS_FAULT) {\n"
                "        axes_stop(i);\n    }",
                "    if (state_of(i) != AXIS_FAULT) {\n        axes_stop(i);\n"
                "        permit_set(i == 0 && permit_is_on());\n    }",
            ),
        ),
        limits=("--actions", "2", "--periods", "1", "--from", "loaded, moment 0"),
    ),
    Plant(
        "a halt that leaves the rest of a train to be made",
        FAULT,
        (Change(ENGINE_H, "engine->cut = left;\n        engine->left = 0;", ""),),
        (TIMER,),
        limits=(*ONE, "--from", "both run, moment 20"),
    ),
)


if __name__ == "__main__":
    plant_all(PLANTS, "explore_two.plants")
