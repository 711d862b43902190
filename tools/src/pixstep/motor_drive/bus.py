# SPDX-License-Identifier: MIT
"""One bus and the drives of its motors: a thread of its own that gives each its turn.

One request goes out at a time. Before each request the thread decides what comes first:

1. a stop;
2. a block of a line whose queue is empty soon;
3. a motion that is to begin: its blocks, and arm. Several take turns;
4. what is due first of the rest: a look at a board, a block of a line that is streamed.

So a command waits only for the request that is on its way, and for one request of each other motion
that begins at the same time. Boards are looked at every 0.1 s while something of them moves, every
0.5 s otherwise, and when a motion should be over. A look takes a bus of 115,200 baud 18 ms (Mega,
four motors) or 12 ms (Uno).

The time is that of the bus' link. That of simulated boards passes only while someone lets it pass:
`px.VirtualBus.let_pass`, or `Pacer`, which lets it pass as quickly as the wall clock's.
"""

from __future__ import annotations

import contextlib
import logging
import math
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import Self

from pixstep.board import shared_time
from pixstep.board.errors import BoardError
from pixstep.board.link import Link
from pixstep.errors import PlainError
from pixstep.motor_drive.axis import AxisDrive
from pixstep.motor_drive.starting import DrivenMotor
from pixstep.motor_drive.watch import MOVING_S, RESTING_S, BoardWatch

_SOON_S = 0.015  # between two looks at what should be over
_LEAST_S = 1e-5  # of a wait: some cycles of a simulated board, so that its time goes on
_CLOSES_S = 3.0
_SLICE_S = 0.01
_log = logging.getLogger(__name__)


class BusDrives(Mapping[str, AxisDrive]):
    """The drives of the motors of one bus, by name; use it as a context manager, or `close` it.

    `link` is an open bus: that of `px.connect(port).link`, which goes through a running `pixstep
    serve` by itself, or of simulated boards. It stays the caller's, who closes it afterwards.
    `clock_hz` and `divider` are set on each board when it is found and at rest, if they are given.
    `kinds` says by address what boards should be: another one is told nothing.
    """

    def __init__(
        self,
        link: Link,
        motors: Sequence[DrivenMotor],
        *,
        clock_hz: Fraction | None = None,
        divider: int | None = None,
        kinds: Mapping[int, str] | None = None,
    ) -> None:
        self.link = link
        self._time = shared_time.of_link(link)
        units: dict[int, list[DrivenMotor]] = {}
        for motor in motors:
            units.setdefault(motor.unit, []).append(motor)
        self._watches = {
            unit: BoardWatch(
                link,
                unit,
                1 + max(motor.axis for motor in ours),
                clock_hz,
                divider,
                len(ours),
                (kinds or {}).get(unit),
            )
            for unit, ours in units.items()
        }
        self._drives = {
            motor.name: AxisDrive(self, self._watches[motor.unit], motor) for motor in motors
        }
        self._of_board = {
            unit: [self._drives[motor.name] for motor in ours] for unit, ours in units.items()
        }
        self._turn = 0
        self._closing = False
        self._over = threading.Event()
        self.failure: BaseException | None = None
        """What has ended the thread before its time; None: nothing."""
        self._thread = threading.Thread(target=self._run, name="pixstep motors", daemon=True)
        self._thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __getitem__(self, name: str) -> AxisDrive:
        return self._drives[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._drives)

    def __len__(self) -> int:
        return len(self._drives)

    def wake(self) -> None:
        """There is something to do; from any thread."""
        self._time.wake()

    def now_s(self) -> float:
        """Return the boards' time."""
        return self._time.now_s()

    @property
    def motions(self) -> int:
        """How many motions there are."""
        return sum(drive.work.busy for drive in self._drives.values())

    def close(self) -> None:
        """Stop what the drives move, and end the thread."""
        for drive in self._drives.values():
            drive.close()
        self._closing = True
        self.wake()
        self._time.pass_until(self._over, 2 * _CLOSES_S)

    def _run(self) -> None:
        """Serve the drives: this is the thread."""
        try:
            self._time.enter()
            with self.link.modbus.turns.favoured():
                self._serve()
        except BaseException as error:
            self.failure = error
            _log.exception("%s: the drives have ended", self.link.port)
        finally:
            self._over.set()
            self._time.leave()

    def _serve(self) -> None:
        ends_s = None
        while True:
            if self._closing:
                ends_s = ends_s or self.now_s() + _CLOSES_S
                stopped = not any(
                    one.work.busy or one.work.stop_due for one in self._drives.values()
                )
                if stopped or self.now_s() > ends_s:
                    return
            if not self._one_request():
                self._time.wait(max(_LEAST_S, self._due_s() - self.now_s()))

    def _one_request(self) -> bool:
        """Do what comes first, one request as a rule; False if nothing is due."""
        drives = list(self._drives.values())
        for drive in drives:
            self._shielded(drive, drive.work.take)
            if drive.work.gives_up_s <= self.now_s():
                self._shielded(drive, drive.work.lost)
        if self._stop(drives) or self._feed(drives) or self._launch(drives):
            return True
        now_s = self.now_s()
        streams = [(drive.work.due_s, drive) for drive in drives]
        looks = [(self._look_due_s(unit), unit) for unit in self._watches]
        stream = min(streams, key=lambda one: one[0])
        look = min(looks)
        if min(stream[0], look[0]) > now_s:
            return False
        if look[0] <= stream[0]:
            self._look(look[1])
        else:
            self._shielded(stream[1], stream[1].work.step)
        return True

    def _stop(self, drives: Iterable[AxisDrive]) -> bool:
        for drive in drives:
            watch = self._watches[drive.motor.unit]
            if drive.work.stop_due and not (watch.failures and self.now_s() < watch.due_s):
                with contextlib.suppress(BoardError):
                    drive.work.send_stop()
                    return True
                self._lost(watch)
        return False

    def _feed(self, drives: Iterable[AxisDrive]) -> bool:
        """Fill the queue that is empty first: a line that breaks off is a fault of its board."""
        left_s, drive = min(
            ((drive.work.left_s, drive) for drive in drives), key=lambda one: one[0]
        )
        if left_s == math.inf:
            return False
        self._shielded(drive, drive.work.step)
        return True

    def _launch(self, drives: Sequence[AxisDrive]) -> bool:
        """Let a motion that begins have its turn."""
        for offset in range(len(drives)):
            drive = drives[(self._turn + offset) % len(drives)]
            if drive.work.launches:
                self._turn = (self._turn + offset + 1) % len(drives)
                self._shielded(drive, drive.work.step)
                return True
        return False

    def _shielded(self, drive: AxisDrive, do: Callable[[], None]) -> None:
        """Do something for a drive; what fails there against all expectation ends its motion."""
        try:
            do()
        except Exception as error:
            _log.exception("%s: the drive has failed", drive.motor.name)
            drive.work.failed(f"the drive has failed: {error!r}")

    def _look(self, unit: int) -> None:
        """Look at a board."""
        watch = self._watches[unit]
        try:
            look = watch.look()
        except PlainError:
            self._lost(watch)
            return
        for drive in self._of_board[unit]:
            self._shielded(drive, partial(drive.work.looked, look))
        moves = any(axis.moves for axis in look.axes)
        moves = moves or any(drive.work.busy for drive in self._of_board[unit])
        watch.due_s = self.now_s() + (MOVING_S if moves else RESTING_S)

    def _lost(self, watch: BoardWatch) -> None:
        watch.due_s = self.now_s() + watch.pause_s
        for drive in self._of_board[watch.unit]:
            self._shielded(drive, drive.work.lost)

    def _look_due_s(self, unit: int) -> float:
        """Return when a board is to be looked at: also when something of it should be over."""
        watch = self._watches[unit]
        if watch.failures:
            return watch.due_s
        earliest = watch.newest.time_s + _SOON_S if watch.newest else 0.0
        expected = min(drive.work.look_due_s for drive in self._of_board[unit])
        return min(watch.due_s, max(earliest, expected))

    def _due_s(self) -> float:
        """Return when something is due at the latest."""
        return min(
            *(drive.work.due_s for drive in self._drives.values()),
            *(drive.work.gives_up_s for drive in self._drives.values()),
            *(self._look_due_s(unit) for unit in self._watches),
            self.now_s() + RESTING_S,
        )


class Pacer:
    """Lets the time of a simulated bus pass as quickly as the wall clock's, in a thread of its own.

    Where the simulator cannot keep up, its time passes more slowly. A context manager.
    """

    def __init__(self, link: Link) -> None:
        self._lender, self._port = shared_time.lender_of(link), link.port
        self._ends = threading.Event()
        self.failure: PlainError | None = None
        """Why no more time passes, as where the simulator has ended; None: it does."""
        self._thread = threading.Thread(target=self._run, name="pixstep pacer", daemon=True)
        self._thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Let no more time pass."""
        self._ends.set()
        self._thread.join()

    def _run(self) -> None:
        """Let time pass: this is the thread."""
        try:
            self._pace()
        except PlainError as error:
            self.failure = error
            _log.error("%s: its time stands still: %s", self._port, error)

    def _pace(self) -> None:
        ahead_s = time.monotonic() - self._lender.world.now_s()
        while not self._ends.is_set():
            behind_s = time.monotonic() - ahead_s - self._lender.world.now_s()
            if behind_s < _SLICE_S:
                self._ends.wait(_SLICE_S - behind_s)
            self._lender.pass_time(_SLICE_S)
            if behind_s > 1.0:  # too slow: do not try to catch up
                ahead_s = time.monotonic() - self._lender.world.now_s()
