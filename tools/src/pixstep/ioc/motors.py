# SPDX-License-Identifier: MIT
"""A motor record that is served: its model, its motor's drive, its PVs, and who waits for it."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import caproto

from pixstep.ioc import channels, common
from pixstep.ioc.channels import SHAPE, FieldChannel
from pixstep.motor_record import (
    FIELDS,
    Mip,
    MotorCommand,
    MotorRecord,
    Msta,
    PutRefusedError,
    Verb,
)
from pixstep.motor_record.field import Alarm, Severity, names_a_record

if TYPE_CHECKING:
    from pixstep.ioc.saved import SavedRecord
    from pixstep.motor_record import Drive, Outcome, Status
    from pixstep.motor_record.field import Value

Tell = Callable[..., None]
FindPv = Callable[[str], "FieldChannel | None"]
# Fields that name another PV, whose value the record takes.
LINKS: tuple[Literal["DOL", "RDBL"], ...] = ("DOL", "RDBL")


class ServedMotor:
    """One record. Everything but `_report` runs in the loop of the server."""

    def __init__(
        self, name: str, kept: SavedRecord, drive: Drive, tell: Tell, find: FindPv
    ) -> None:
        self.name, self.record, self._kept = name, MotorRecord(kept.fields), kept
        self.is_ready = False
        self.is_lost = False
        self._problem = ""
        self._last: Status | None = None
        self._drive, self._tell, self._find = drive, tell, find
        self._loop: asyncio.AbstractEventLoop | None = None
        self._statuses: asyncio.Queue[Status] = asyncio.Queue()
        self._turn = asyncio.Lock()
        self._waiting: list[asyncio.Future[None]] = []
        # Until the first status nothing is known of the motor.
        self._alarm = caproto.ChannelAlarm(status=Alarm.UDF, severity=Severity.INVALID)
        self._announced = False
        self._shape: tuple[Value, ...] = ()
        self._linked: dict[str, float | None] = dict.fromkeys(LINKS)
        self._tasks: set[asyncio.Future[None]] = set()
        self.ready = asyncio.Event()
        self.pvs: dict[str, FieldChannel] = {
            name: channels.of_field(self, field, self._alarm) for name, field in common.ALL.items()
        }

    def __getitem__(self, field: str) -> Value:
        """Return a field as it is now."""
        if field == "NAME":
            return self.name
        if not self.is_ready and field in ("STAT", "SEVR"):  # the record itself has not begun
            return int(self._alarm.status if field == "STAT" else self._alarm.severity)
        if not self.is_ready and field == "UDF":
            return 1
        return common.VALUES[field] if field in common.COMMON else self.record[field]

    @property
    def offset_steps(self) -> int:
        """What the drive adds to the board's register."""
        return self._drive.offset_steps

    @property
    def is_moving(self) -> bool:
        """True while the record waits for its motor."""
        return self.is_ready and self.record["DMOV"] == 0

    async def run(self) -> None:
        """Follow the motor until this is cancelled."""
        self._loop = asyncio.get_running_loop()
        self._drive.connect(self._report)
        self._drive.obey([MotorCommand(Verb.GET_INFO)])
        while True:
            status = await self._statuses.get()
            async with self._turn:
                try:
                    await self._take(status)
                except Exception as error:  # the other motors go on, whatever this one has
                    self._tell("trouble", motor=self.name, what=f"{type(error).__name__}: {error}")

    def _report(self, status: Status) -> None:
        """Take a status from the driver's own thread."""
        assert self._loop is not None
        with contextlib.suppress(RuntimeError):  # the loop has ended: nobody is interested
            self._loop.call_soon_threadsafe(self._statuses.put_nowait, status)

    async def _take(self, status: Status) -> None:
        if self._drive.overtaken(status):
            return
        self._note_loss(bool(status.flags & Msta.COMM_ERR))
        self._note_problem(bool(status.flags & Msta.PROBLEM))
        self._last = status
        if self.is_ready:
            await self._take_links()
            if self._was_stopped(status):
                await self._give_up()
            outcome = self.record.update(status)
            if self._announced and status.flags & Msta.DONE and not outcome.commands:
                self._drive.obey(())  # what was announced is not wanted
                self._announced = False
            await self._act(outcome)
        elif not status.flags & Msta.COMM_ERR:
            self.is_ready = True
            status = self._with_offset(status)
            await self._act(self.record.initialise(status))
            if status.flags & Msta.MOVING:  # a record that begins shows DMOV = 1 until then
                await self._act(self.record.update(status))
            await self._show_all()
            self.ready.set()

    @property
    def why(self) -> dict[str, str]:
        """Why the motor cannot be had, for the log, if its drive can say that."""
        problem = self._drive.problem
        return {"why": problem} if problem else {}

    def _was_stopped(self, status: Status) -> bool:
        """Return whether somebody else has stopped what the record moves."""
        own = not self.record["DMOV"] and not int(self.record["MIP"]) & Mip.EXTERNAL
        return bool(own and self._drive.stopped_elsewhere and status.flags & Msta.DONE)

    async def _give_up(self) -> None:
        """Write STOP: the record would go on to its target by a retry. The motor rests already."""
        with contextlib.suppress(PutRefusedError):
            await self._act(replace(self.record.put("STOP", 1), commands=(), second_leg=()))

    def _with_offset(self, status: Status) -> Status:
        """Return the first status with the offset of the last server's positions, if it holds."""
        register = status.position_steps - self.offset_steps
        offset = self._kept.offset_at(register) - self.offset_steps
        if not offset:
            return status
        self._drive.add_offset(offset)
        self._drive.obey([MotorCommand(Verb.GET_INFO)])  # what was reported before lacks the offset
        return replace(status, position_steps=status.position_steps + offset)

    def _note_loss(self, lost: bool) -> None:
        if lost != self.is_lost:
            self.is_lost = lost
            self._tell("connection lost" if lost else "connection back", motor=self.name)

    def _note_problem(self, there: bool) -> None:
        """Tell once why the motor has a problem, if its drive can say that."""
        why = self._drive.problem if there else ""
        if why and not self.is_lost and why != self._problem:
            self._tell("problem", motor=self.name, why=why)
        if why or not there:
            self._problem = why

    async def put(self, field: str, value: Value) -> None:
        """Write a field for a client; return when the motion that follows is over."""
        if field in common.COMMON:
            raise PutRefusedError(field, value, "it cannot be written")
        if not self.is_ready:
            raise PutRefusedError(field, value, f"the board of {self.name} has not answered yet")
        async with self._turn:
            await self._take_links()
            outcome = self.record.put(field, value)
            await self._act(outcome)
            if self.is_lost and self._last is not None and not outcome.commands:
                # The record drops COMM_ERR once it has seen it: the motor is as lost as before.
                await self._act(self.record.update(self._last))
            if field in LINKS:
                self._judge_link(field)
            is_over = outcome.complete or self.record["DMOV"] != 0
            if is_over or not FIELDS[field].processes:
                return
            end = asyncio.get_running_loop().create_future()
            self._waiting.append(end)
        await end

    async def stop(self) -> None:
        """Stop the motor as a client does."""
        if self.is_moving:
            with contextlib.suppress(PutRefusedError):
                await self.put("STOP", 1)

    def close(self) -> None:
        """Let go of the motor, which is stopped if it still moves."""
        self._drive.close()

    async def _act(self, outcome: Outcome) -> None:
        """Do what an event has brought about: the motor first, then the clients."""
        now_s = time.time()
        if outcome.commands:
            self._drive.obey(outcome.commands, outcome.second_leg)
            self._announced = bool(outcome.second_leg)
        status, severity = int(self.record["STAT"]), int(self.record["SEVR"])
        alarmed = await channels.raise_alarm(self._alarm, status, severity)
        for post in outcome.posts:
            await self.pvs[post.field].post(post.value, now_s)
        await self._show_shape()
        if alarmed:
            posted = {post.field for post in outcome.posts}
            for name in {"VAL", "RBV"} - posted:
                await self.pvs[name].post_alarm()
        if outcome.delay_s is not None:
            asyncio.get_running_loop().call_later(outcome.delay_s, self._end_delay)
        if outcome.complete or self.record["DMOV"] != 0:
            self._let_go()
        forgotten = self.record.forget_refused_jog()
        if forgotten:
            await self._act(forgotten)

    def _let_go(self) -> None:
        for end in self._waiting:
            if not end.done():
                end.set_result(None)
        self._waiting.clear()

    def _end_delay(self) -> None:
        task = asyncio.ensure_future(self._delay_over())
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _delay_over(self) -> None:
        async with self._turn:
            await self._act(self.record.delay_over())

    async def _show_shape(self) -> None:
        """Tell clients of other units and limits, where these have changed."""
        shape = tuple(self.record[name] for name in SHAPE)
        if shape == self._shape:
            return
        self._shape = shape
        for pv in self.pvs.values():
            if pv.field.limits or pv.field.unit:
                await pv.post_shape()

    async def _show_all(self) -> None:
        """Tell clients all fields, which were unknown until now."""
        now_s = time.time()
        for name, pv in self.pvs.items():
            await pv.post(self[name], now_s)

    def _linked_pv(self, link: str) -> FieldChannel | None:
        name = str(self.record[link]).split(" ")[0]
        return self._find(name) if name else None

    async def _take_links(self) -> None:
        """Give the record the values of the PVs that its links name."""
        for link in LINKS:
            if not self.record[link]:
                continue
            pv = self._linked_pv(link)
            try:
                value = None if pv is None else float(pv.now())
            except (TypeError, ValueError):
                value = None
            if value != self._linked[link]:
                self._linked[link] = value
                await self._act(self.record.set_link(link, value))

    def _judge_link(self, link: str) -> None:
        """Tell of a link that names no PV of this server."""
        text = str(self.record[link])
        if names_a_record(text) and self._linked_pv(link) is None:
            self._tell("dead link", motor=self.name, field=link, names=text)
