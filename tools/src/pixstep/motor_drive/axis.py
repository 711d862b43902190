# SPDX-License-Identifier: MIT
"""The drive of one motor: a record's commands become motions of a board's axis, statuses go back.

Two sides share it. Any thread may call what `traffic.Drive` promises: `connect`, `obey`, `close`.
The bus' own thread does the rest, one request at a time, when `bus.BusDrives` gives it its turn.

    obey --> inbox --> take(): actions --> a motion --> step(): blocks, arm, stream
                                              ^                     |
                        statuses <-- looked(): what the board says of it

A motion has ended when the board says that its axis rests and is not stopping: no STEP edge can
come then. If the board does not answer, the motion has ended when the last line that was queued
must be over.

*Second legs.* `obey` may announce what the record will ask for next, the final approach against
backlash. Its line is queued some 1.2 s before the first leg ends, and the board goes from leg to
leg by itself. The record sees the first leg end: one DONE status at the first leg's target. Until
it answers nothing is reported. If it gives the commands that it has announced, they are already
being carried out and move nothing twice. If it gives others, or none within a second, the board is
stopped, and they begin where the motor is then. The lines of a drive never take up backlash by
themselves: the record's two legs do it.

*Positions* are the board's register and an offset that the drive keeps: see `set_position`. After a
reset of the board the position is unknown: the last one is shown with PROBLEM, and no move begins
until a homing or LOAD_POS has given the position a meaning; a jog may.
"""

from __future__ import annotations

from collections.abc import Sequence

from pixstep.motor_drive.starting import DrivenMotor
from pixstep.motor_drive.statuses import Inbox, OnStatus, TurnGiver
from pixstep.motor_drive.watch import BoardWatch
from pixstep.motor_drive.work import AxisWork
from pixstep.motor_record.traffic import MotorCommand, Status


class AxisDrive:
    """A `traffic.Drive` of one motor; `bus.BusDrives` makes them. From any thread."""

    def __init__(self, owner: TurnGiver, watch: BoardWatch, motor: DrivenMotor) -> None:
        self.motor = motor
        self._owner, self._watch, self._inbox = owner, watch, Inbox()
        self.work = AxisWork(owner, watch, motor, self._inbox)
        """What the bus' thread does for it; for that thread alone."""

    def connect(self, on_status: OnStatus) -> None:
        """Begin to report; the first status follows the next look at the board."""
        self._inbox.listen(on_status)
        self._owner.wake()

    def obey(
        self, commands: Sequence[MotorCommand], second_leg: Sequence[MotorCommand] = ()
    ) -> None:
        """Take the commands of one Outcome, in order.

        Give it the Outcome of each status, also one without commands. At the end of a first leg an
        Outcome without commands says that the second leg is not wanted, and the motor is stopped at
        once. A drive that is told nothing stops the motor only after a second.
        """
        self._inbox.put(commands, second_leg)
        self._owner.wake()

    def overtaken(self, status: Status) -> bool:
        """Whether a status that was reported is older than the newest call of `obey`.

        Whoever hands statuses from the bus' thread to another one asks this there, and drops those
        that are: a motor that rested before a GO would else look like the end of the move. A newer
        status always follows.
        """
        return self._inbox.overtaken(status)

    @property
    def offset_steps(self) -> int:
        """What the drive adds to the board's register; gone with the process (`set_position`)."""
        return self.work.known.offset_steps

    def add_offset(self, steps: int) -> None:
        """Take over the offset that an earlier drive had: before the first command, moving or not.

        Statuses that were reported before do not have it yet; `overtaken` finds those once another
        command was given.
        """
        self.work.add_offset(steps)

    @property
    def problem(self) -> str:
        """Why PROBLEM or COMM_ERR is set, in words; "" if neither is."""
        return self._watch.trouble or self.work.statuses.problem

    @property
    def stopped_elsewhere(self) -> bool:
        """Whether another program, or the emergency stop, has stopped the last motion.

        A record that sees it rest before its target would go on by a retry: whoever serves one
        writes STOP first.
        """
        return self.work.statuses.stopped_elsewhere

    @property
    def top_speed_steps_s(self) -> float:
        """The highest speed that the board makes while all of its motors move; 0: not known yet.

        A motor's own `max_speed_steps_s` counts as well. Faster moves are made at this speed.
        """
        board = self._watch.top_steps_px * self._watch.pixel_hz if self._watch.limits else 0.0
        return min(board, self.motor.max_speed_steps_s or board)

    def close(self) -> None:
        """Stop the motor if this drive moves it, and report nothing more."""
        self._inbox.close()
        self._owner.wake()
