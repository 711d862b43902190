# SPDX-License-Identifier: MIT
"""Moves, homing and seeks of a board as a program asks for them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from fractions import Fraction
from os import PathLike
from typing import SupportsInt

from pixstep import arguments
from pixstep.api import given
from pixstep.api.given import Hz, maybe
from pixstep.api.machines import Motor
from pixstep.api.motions import Profile
from pixstep.board import settings
from pixstep.board.device import Device
from pixstep.errors import RefusedError, UserError
from pixstep.lines import units
from pixstep.lines.line import PLAIN
from pixstep.moves import fast, legs
from pixstep.moves.fast import Acceleration
from pixstep.moves.homing import Homed, HomingLeg
from pixstep.moves.legs import FILTER_US, INVERTED, SHARED, HomingPlan, HomingRequest, Inputs
from pixstep.moves.on_board import (
    HomingOnBoard,
    MotionClock,
    Moved,
    MoveOnBoard,
    prepare_homing,
    prepare_move,
)
from pixstep.profiles import generator, origin
from pixstep.profiles.generator import MOST_PIXELS

ProfileLike = str | PathLike[str] | Profile | Iterable[SupportsInt]
"""A CSV or CSB file, a Profile, or the steps of each pixel of an acceleration from rest."""


@dataclass(frozen=True)
class MoveResult:
    """A move that was made."""

    unit: int
    """Address of the board."""
    axis: int
    """Axis, from 0."""
    steps: int
    """Steps that the motor made, signed."""
    from_steps: int
    """The board's position before."""
    position_steps: int
    """The board's position now."""
    pixels: int
    """Pixels that it took."""
    seconds: float
    """How long it took."""
    top_speed_steps_px: int
    """Its highest speed."""


@dataclass(frozen=True)
class HomeResult:
    """A homing that was made: the switch's edge is position 0."""

    unit: int
    """Address of the board."""
    axis: int
    """Axis, from 0."""
    direction: str
    """Where the load sought the switch: `"plus"` or `"minus"`."""
    edge_steps: int
    """Where the edge was, by the positions before."""
    position_steps: int
    """The board's position now: 0."""
    seconds: float
    """How long all legs took."""
    legs: tuple[HomingLeg, ...] = field(repr=False)
    """Each leg: its name, positions, pixels and times."""


@dataclass(frozen=True)
class SeekResult:
    """A seek that was made."""

    unit: int
    """Address of the board."""
    axis: int
    """Axis, from 0."""
    edge_steps: int | None
    """Position at the switch's edge, as the hardware captured it; None if the switch was as sought
    from the start: nothing has moved then."""
    position_steps: int
    """The board's position now, where the axis has slowed down."""
    steps: int
    """Steps that the motor made, signed."""


@dataclass(frozen=True)
class Which:
    """Whose axis moves, and the clock that the board is to have; None is the motor's or board's."""

    axis: int | None = None
    motor: Motor | None = None
    pixel_hz: Hz | None = None
    divider: int | None = None

    def place(self, device: Device) -> int:
        """Return the axis. Raises UserError for one that is not the motor's, or not there."""
        motor = given.motor(self.motor)
        axis = motor.axis if motor else 0
        if self.axis is not None and given.axis(self.axis) != axis:
            if motor:
                raise UserError(f"axis {self.axis}: motor {motor.name} is on axis {axis}")
            axis = given.axis(self.axis)
        kind = device.who().board
        if motor and motor.board != kind:
            raise RefusedError(
                f"motor {motor.name} is on a {motor.board}, board {device.unit} is a {kind}"
            )
        has = device.input("axis_count")
        if axis >= has:
            raise UserError(f"axis {axis}: board {device.unit} has {has}: 0 to {has - 1}")
        return axis

    def clock(self, device: Device) -> MotionClock:
        """Return what the board is to be told of its clock."""
        motor = self.motor
        hz = given.exact_hz(self.pixel_hz) or (motor.pixel_hz if motor else None)
        divider = given.divider(self.divider) or (motor.divider if motor else None)
        if hz is None:
            return MotionClock(None, divider)
        return MotionClock(hz * (divider or settings.divider(device)), divider)

    @property
    def way(self) -> int:
        """-1 if the motor runs backwards for its load to go forwards."""
        return -1 if self.motor and self.motor.negative else 1


def ready_move(
    device: Device,
    steps: int | str,
    profile: ProfileLike | None,
    which: Which,
    max_speed: int | str | None,
    number: int | None,
) -> MoveOnBoard:
    """Check a move and set the board up for it."""
    axis, clock = which.place(device), which.clock(device)
    hz, motor = clock.pixel_hz(device), which.motor
    scale = given.scale(None, motor)
    distance = given.steps("steps", steps, scale, -fast.MAX_STEPS, fast.MAX_STEPS)
    limit = given.limit("max_speed", max_speed, units.SPEED, hz, scale)
    if limit is None and motor:
        limit = motor.limits.max_speed
    known = profile if profile is not None or motor is None else motor.move_profile
    ramp = _acceleration(known, motor.decode if motor else PLAIN, number).limited(limit)
    _refuse_faster(ramp, hz)
    return prepare_move(device, axis, fast.plan(ramp, which.way * distance), clock, ramp.source)


def moved(device: Device, axis: int, found: Moved) -> MoveResult:
    """Return what was made."""
    return MoveResult(
        unit=device.unit,
        axis=axis,
        steps=found.move.steps,
        from_steps=found.from_steps,
        position_steps=found.to_steps,
        pixels=found.move.pixels,
        seconds=found.seconds,
        top_speed_steps_px=found.move.top,
    )


@dataclass(frozen=True)
class Homing:
    """How a home switch is sought, as `Board.home` takes it."""

    direction: str = "plus"
    decode: str | None = None
    haps: int | None = None
    slow: int | str | None = None
    search: int | str = legs.SEARCH_STEPS
    clear: int | str | None = None
    number: int | None = None

    def plan(
        self, profile: ProfileLike | None, which: Which, axis: int, hz: Fraction
    ) -> HomingPlan:
        """Return the legs."""
        motor, scale = which.motor, given.scale(None, which.motor)
        direction = arguments.one_of("direction", self.direction, tuple(legs.DIRECTIONS))
        rule = given.decode(self.decode, motor) if self.decode or motor else PLAIN
        known = profile if profile is not None or motor is None else motor.home_profile
        ramp = _acceleration(known, rule, self.number)
        _refuse_faster(ramp, hz)
        most = legs.MAX_SEARCH_STEPS
        slow = None
        if self.slow is not None:
            slow = units.whole_speed(
                given.quantity("slow", self.slow, units.SPEED, scale), hz, scale,
                smooth=rule != PLAIN,
            )  # fmt: skip
        request = HomingRequest(
            axis=axis,
            direction=which.way * legs.DIRECTIONS[direction],
            turned=which.way < 0,
            haps=maybe(arguments.whole, "haps", self.haps, 1),
            slow=slow,
            search_steps=given.steps("search", self.search, scale, 1, most),
            clear_steps=maybe(given.steps, "clear", self.clear, scale),
            decode=rule,
        )
        return legs.plan(ramp, request, hz)


def inputs(inverted: str | None, filter_us: int | None, home_is_limit: str | None) -> Inputs:
    """Return what the board is to be told of its switches."""
    return Inputs(
        maybe(arguments.one_of, "inverted", inverted, tuple(INVERTED)),
        maybe(arguments.whole, "filter_us", filter_us, *FILTER_US),
        maybe(arguments.one_of, "home_is_limit", home_is_limit, tuple(SHARED)),
    )


def ready_homing(
    device: Device, profile: ProfileLike | None, which: Which, homing: Homing, wanted: Inputs
) -> HomingOnBoard:
    """Check a homing and set the board up for it."""
    axis, clock = which.place(device), which.clock(device)
    plan = homing.plan(profile, which, axis, clock.pixel_hz(device))
    return prepare_homing(device, plan, clock, wanted)


def homed(device: Device, found: Homed) -> HomeResult:
    """Return what was found."""
    return HomeResult(
        unit=device.unit,
        axis=found.plan.axis,
        direction=found.plan.towards,
        edge_steps=found.edge.position_steps,
        position_steps=found.position_steps,
        seconds=found.legs[-1].ended_s - found.legs[0].began_s,
        legs=found.legs,
    )


def sought(device: Device, axis: int, leg: HomingLeg) -> SeekResult:
    """Return what was found."""
    edge = leg.trip.position_steps if leg.trip else None
    return SeekResult(device.unit, axis, edge, leg.end_steps, leg.steps)


def _acceleration(profile: ProfileLike | None, decode: str, number: int | None) -> Acceleration:
    """Return the steps of each pixel of an acceleration."""
    if profile is None:
        raise UserError("profile: none is given, and the motor's machine file names none")
    if isinstance(profile, str | PathLike):
        which = maybe(arguments.whole, "number", number, 1)
        with given.number_for_line():
            return fast.read(arguments.path("profile", profile), number=which)
    if isinstance(profile, Profile):
        return _own(_counts_of(profile, decode), profile.name, profile.pixel_hz)
    return _own(arguments.wholes("profile", profile, 1, fast.MAX_STEPS, MOST_PIXELS))


def _counts_of(profile: Profile, decode: str) -> tuple[int, ...]:
    """Return the steps of each pixel up to the profile's top speed."""
    speeds, top = list(profile.speeds_steps_px), profile.top_speed_steps_px
    if decode == PLAIN:
        return tuple(speeds)
    return (*generator.acceleration_counts(speeds, top, profile.name), top)


def _own(
    counts: tuple[int, ...], name: str = "profile", made_for: Fraction | None = None
) -> Acceleration:
    """Return a program's own acceleration, of which homing may use all."""
    if not counts or list(counts) != sorted(counts) or counts[0] < 1:
        raise UserError(f"{name}: expected steps of each pixel, above 0 and never falling")
    return Acceleration(counts, haps=len(counts), source=name, made_for_hz=made_for)


def _refuse_faster(ramp: Acceleration, hz: Fraction) -> None:
    """Raise RefusedError for a profile that was made for a lower pixel frequency."""
    if ramp.made_for_hz not in (None, hz):
        assert ramp.made_for_hz is not None
        origin.OtherFrequency(ramp.source, ramp.made_for_hz, hz).refuse_faster()
