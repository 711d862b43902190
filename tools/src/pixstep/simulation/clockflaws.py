# SPDX-License-Identifier: MIT
"""How the edges of a simulated pixel clock stray from an even frequency."""

from collections.abc import Iterator
from dataclasses import dataclass

from pixstep.simulation.summary import Flaws

MOST_PPM = 100_000
MOST_JITTER_US = 10_000
MOST_REST_MS = 3_600_000


@dataclass(frozen=True)
class ClockFlaws:
    """What is wrong with a clock; none by default.

    `jitter_us` is the standard deviation of each edge's own displacement. The frequency swings by
    `wander_ppm` to either side, once in 1,000 edges, and from edge `step_edge` on, counted from 0,
    it is `step_ppm` higher. One edge of `drop` is missing, and one edge of `double` is followed by
    a false one; 0 is none. A gate lets `gate_edges` edges pass and rests for `gate_rest_ms` besides
    the period, again and again; 0 edges are no gate.
    """

    jitter_us: float = 0.0
    wander_ppm: float = 0.0
    step_ppm: float = 0.0
    step_edge: int = 0
    drop: int = 0
    double: int = 0
    gate_edges: int = 0
    gate_rest_ms: float = 0.0

    @property
    def even(self) -> bool:
        """True if all edges but false ones are where an even clock with such rests has them."""
        return not (self.jitter_us or self.wander_ppm or self.step_ppm)

    def arguments(self) -> list[str]:
        """Return the runner's options."""
        words = []
        if self.jitter_us:
            words += ["--pixel-jitter-rms-ns", str(round(1000 * self.jitter_us))]
        if self.wander_ppm:
            words += ["--pixel-wander-ppm", repr(self.wander_ppm)]
        if self.step_ppm:
            words += ["--pixel-step", f"{self.step_ppm!r}@{self.step_edge}"]
        for option, every in (("--pixel-drop", self.drop), ("--pixel-double", self.double)):
            words += [option, str(every)] if every else []
        if self.gate_edges:
            words += ["--pixel-gate", f"{self.gate_edges},{self.gate_rest_ms!r}"]
        return words

    def texts(self) -> Iterator[str]:
        """Yield each flaw in words."""
        if self.jitter_us:
            yield f"jitter {self.jitter_us:g} us rms"
        if self.wander_ppm:
            yield f"wander {self.wander_ppm:g} ppm"
        if self.step_ppm:
            yield f"{self.step_ppm:+g} ppm from edge {self.step_edge} on"
        if self.drop:
            yield f"1 edge of {self.drop} missing"
        if self.double:
            yield f"1 edge of {self.double} doubled"
        if self.gate_edges:
            yield f"gate of {self.gate_edges} edges, rests of {self.gate_rest_ms:g} ms"

    def as_json(self) -> Flaws:
        """Return plain data."""
        return {
            "jitter_us": self.jitter_us,
            "wander_ppm": self.wander_ppm,
            "step_ppm": self.step_ppm,
            "step_edge": self.step_edge,
            "drop": self.drop,
            "double": self.double,
            "gate_edges": self.gate_edges,
            "gate_rest_ms": self.gate_rest_ms,
        }
