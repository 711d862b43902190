# SPDX-License-Identifier: MIT
"""What requests cost a board whose axes move: the longest one, and a saturated bus by the byte."""

from fractions import Fraction
from typing import Any

from pixstep.board import boards, costs
from pixstep.simulation.simulated_board import SerialLoad, SimulatedBoard
from pixstep.simulation.simulator import Simulator
from pixstep_dev.bench import sections, turns
from pixstep_trials import lines

_HZ, _RATE = Fraction(100), 12_000  # steps/s of all axes together
_SECONDS = 30
_LOAD_S = 1.0
_TURNING = ", turning"


def measure(board: str) -> dict[str, float]:
    """Return the costs that the bus causes."""
    axes = list(range(boards.load(board).axes))
    count = lines.count_at(_RATE // len(axes), _HZ)
    with SimulatedBoard(board, _HZ) as under:
        under.set_up(_HZ, axes, bus_timeout_ms=0)
        under.load(dict.fromkeys(axes, lines.constant(count, int(_SECONDS * _HZ))))
        under.arm()
        under.link.world.wait(0.3)
        simulator = under.simulator
        before = _row(simulator)
        simulator.run(simulator.cycles(0.2))
        idle = sections.bus(before, _row(simulator))
        a_pass = idle[0] / idle[1]
        load = SerialLoad(under.board, axes, under.uploads)
        before = _row(simulator)
        simulator.mark()
        end = simulator.cycle + simulator.cycles(_LOAD_S)
        while simulator.cycle < end:
            load.until(simulator, end)
        after = _row(simulator)
        spent, passes = sections.bus(before, after)
        handlers = {row["name"]: row for row in after["handlers"]}
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


def _row(simulator: Simulator) -> dict[str, Any]:
    row: dict[str, Any] = simulator.stats()["boards"][0]
    return row


def requests(turned: list[dict[str, Any]]) -> dict[str, float]:
    """Return the longest request, that brings line data, that brings those of a line that turns.

    Each up to an interlude, and whole.
    """
    found: dict[str, float] = {}
    for row in turned:
        text = str(row["request"])
        kind = costs.DATA if text.startswith("block") else ""
        kind = costs.TURNING if text.endswith(_TURNING) else kind
        for name, cycles in ((costs.REQUEST, "request_cycles"), (costs.WHOLE, "whole_cycles")):
            if name == costs.WHOLE and text == turns.SPOILT:
                continue  # a checksum, in which edges are taken
            found[kind + name] = max(found.get(kind + name, 0.0), row[cycles])
    return found
