# SPDX-License-Identifier: MIT
"""What requests cost a board whose axes move: the longest one, and a saturated bus by the byte."""

from fractions import Fraction
from typing import Any

from pixstep.board import boards
from pixstep.simulation.simulated_board import SerialLoad, SimulatedBoard
from pixstep_dev.bench import sections, turns
from pixstep_trials import lines

_HZ, _RATE = Fraction(100), 12_000  # steps/s of all axes together
_SECONDS = 30
_LOAD_S = 1.0
_TURNING = ", turning"


def costs(board: str) -> dict[str, float]:
    """Return the costs that the bus causes."""
    axes = list(range(boards.load(board).axes))
    count = lines.count_at(_RATE // len(axes), _HZ)
    with SimulatedBoard(board, _HZ) as under:
        under.set_up(_HZ, axes, bus_timeout_ms=0)
        under.load(dict.fromkeys(axes, lines.constant(count, int(_SECONDS * _HZ))))
        under.arm()
        under.link.world.wait(0.3)
        simulator = under.simulator
        before = simulator.stats()
        simulator.run(simulator.cycles(0.2))
        idle = _serial(before, simulator.stats())
        a_pass = idle[0] / idle[1]
        load = SerialLoad(under.board, axes, under.uploads)
        before = simulator.stats()
        simulator.mark()
        end = simulator.cycle + simulator.cycles(_LOAD_S)
        while simulator.cycle < end:
            load.until(simulator, end)
        after = simulator.stats()
        spent, passes = _serial(before, after)
        handlers = {row["name"]: row for row in after["boards"][0]["handlers"]}
        sent = sum(
            row["count"] for name, row in handlers.items() if name.endswith(("_RX", "_UDRE"))
        )
        states = under.states()
    assert set(states.values()) == {"running"}, states
    byte = max(
        row["cycles_mean"]
        for name, row in handlers.items()
        if "USART" in name and "_TX" not in name
    )
    turned = turns.measure(board)  # the longest of each kind
    return {
        **requests(turned),
        "request_byte": max(0.0, spent - a_pass * passes) / sent,
        "byte_isr": byte,
    }


def requests(turned: list[dict[str, Any]]) -> dict[str, float]:
    """Return the longest request, that brings line data, that brings those of a line that turns."""
    found = dict.fromkeys(("request", "data_request", "turning_request"), 0.0)
    for row in turned:
        text = str(row["request"])
        name = "data_request" if text.startswith("block") else "request"
        name = "turning_request" if text.endswith(_TURNING) else name
        found[name] = max(found[name], row["request_cycles"])
    return found


def _serial(before: dict[str, Any], after: dict[str, Any]) -> tuple[int, int]:
    """Return the cycles of requests and the passes of the main loop between two moments.

    The cycles are with the interludes, but without what those decode.
    """
    old, new = before["boards"][0], after["boards"][0]
    places = [sections.SECTIONS.index(name) for name in ("serial", "interlude")]
    return (
        sum(new["sections"][place] - old["sections"][place] for place in places),
        sections.passes(new) - sections.passes(old),
    )
