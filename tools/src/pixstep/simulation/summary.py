# SPDX-License-Identifier: MIT
"""What summary.json holds of a simulated run."""

from typing import Any, NotRequired, TypedDict


class Handler(TypedDict):
    """Figures of one interrupt, in cycles."""

    vector: int
    name: str
    count: int
    cycles_min: int
    cycles_sum: int
    cycles_mean: float
    cycles_max: int
    latency_max: int


Stats = dict[str, Any]  # what the runner answers to `stats`: cycle, times, each board's counts


class Flaws(TypedDict):
    """How a clock strays from an even frequency (ClockFlaws)."""

    jitter_us: float
    wander_ppm: float
    step_ppm: float
    step_edge: int
    drop: int
    double: int
    gate_edges: int
    gate_rest_ms: float


class Clock(TypedDict):
    """What the clock did, and what the board says of it if it has measured it."""

    sync: str
    divider: int
    flaws: Flaws
    true_edges: int
    missing_edges: int
    false_edges: int
    board_missing: NotRequired[int]
    board_glitches: NotRequired[int]
    board_period_ticks: NotRequired[float]
    board_offset_ppm: NotRequired[float]
    board_jitter_ticks: NotRequired[float]


class AxisClock(TypedDict):
    """How an axis kept to the clock."""

    pixels: int
    line_zero_edge: int
    max_error_ticks: float
    max_error_pixel: int
    rms_error_ticks: float
    drift_ticks: float
    drift_pixels: float
    drift_steps: float
    max_position_error_steps: int
    ripple_ticks: float
    ripple_ppm: float
    ripple_steps_s: float


class Load(TypedDict):
    """The largest load errors of an axis; a pixel is None where there is no error."""

    max_load_error_steps: int
    max_load_error_pixel: int | None
    max_load_error_outside_steps: int
    max_load_error_outside_pixel: int | None
    transitions: list[list[int]]


class Axis(TypedDict):
    """What one axis did."""

    board: int
    axis: int
    verdict: str
    reasons: list[str]
    steps: int
    expected_steps: int
    underruns: int
    line_zero_cycle: int | None
    max_edge_error_ticks: float
    rms_edge_error_us: float
    rate_error_ppm: float
    max_interval_error_ticks: float
    last_steps_on_edge: int
    last_steps_off_edge: int
    pixels: NotRequired[int]
    pixels_equal: NotRequired[int]
    clock: NotRequired[AxisClock | None]
    load: NotRequired[Load]


class Refusal(TypedDict):
    """Why the board refused a line, and how many steps its axes made all the same."""

    axis: int
    name: str
    pixel: int
    step_edges: int


class Shares(TypedDict):
    """Shares of the cycles from arming to the end; None if the run did not get so far."""

    cpu_share: float | None
    interrupt_share: float | None
    section_cycles: list[int] | None


class Move(TypedDict):
    """The plan of a fast move."""

    steps: int
    pixels: int
    seconds: float
    top_steps_px: int
    top_steps_s: float
    runs: list[list[int]]


class MoveMade(Move):
    """The same, and where the move ended."""

    position_register_steps: int | None
    counted_steps: int
    moved_s: float | None


class Summary(Shares):
    """All figures of a run."""

    verdict: str
    reasons: list[str]
    refusal: Refusal | None
    board: str
    decode: str
    pixel_hz: str
    pixel_ppm: float
    clock: Clock
    tick_hz: int
    seed: int
    record_every: int
    serial_load: bool
    requests: dict[str, int]
    axes: list[Axis]
    handlers: list[Handler]
    stack_free_bytes: int
    stack_used_bytes: int | None
    interrupts_off_max_cycles: int | None
    realtime_factor: float
    simulated_s: float
    wall_s: float
    line_zero_cycle: NotRequired[int | None]
    clock_edge_cycle: NotRequired[int | None]
    line_zero_periods: NotRequired[int]
    line_zero_error_cycles: NotRequired[int]
    move: NotRequired[MoveMade]
    plots: NotRequired[list[str]]
