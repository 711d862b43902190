# SPDX-License-Identifier: MIT
"""How the edges of a simulated pixel clock stray from an even frequency."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass

MOST_PPM = 100_000
MOST_JITTER_US = 10_000


@dataclass(frozen=True)
class ClockFlaws:
    """What is wrong with a clock; none by default.

    `jitter_us` is the standard deviation of each edge's own displacement. The frequency swings by
    `wander_ppm` to either side, once in 1,000 edges, and from edge `step_edge` on, counted from 0,
    it is `step_ppm` higher. One edge of `drop` is missing, and one edge of `double` is followed by
    a false one; 0 is none.
    """

    jitter_us: float = 0.0
    wander_ppm: float = 0.0
    step_ppm: float = 0.0
    step_edge: int = 0
    drop: int = 0
    double: int = 0

    @property
    def even(self) -> bool:
        """True if all edges that are no false ones are where an even frequency has them."""
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

    def as_json(self) -> dict:
        """Return plain data."""
        return asdict(self)
