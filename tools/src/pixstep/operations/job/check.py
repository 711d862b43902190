# SPDX-License-Identifier: MIT
"""Compare a job with the machine: its file of today, and what the boards hold."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, cast

from pixstep.errors import FINE, MISUSE, NEGATIVE, AskedText
from pixstep.operations import shared
from pixstep.operations.desk import Desk
from pixstep.operations.job import buses
from pixstep.operations.job.buses import Compares
from pixstep.operations.job.reading import job_file, read
from pixstep.operations.kinds import TEXT
from pixstep.operations.request import flag, operation, option
from pixstep.operations.result import Page, Result
from pixstep.simulation.report import new_table

if TYPE_CHECKING:
    from pixstep.jobs.comparison import ComparisonRow
    from pixstep.jobs.job import Job
    from pixstep.machine.files import MachineFile

KEY_MARK = "\N{BLACK DIAMOND}"
STYLES = {"green": "green", "grey": "bright_black", "amber": "yellow", "red": "red"}
_STATUSES = {"green": FINE, "amber": NEGATIVE, "red": MISUSE}
LEGEND = (
    f"{KEY_MARK} key field: it decided the counts of the lines\n"
    f"green: equal; grey: differs, and makes no difference; amber: agree before anything moves; "
    f"red: do not print"
)


class ComparedField(TypedDict):
    """A field of the configuration: what the job says, what was found, what that means.

    `place` is the file or the board where it was found; `key` fields decided the lines' counts.
    """

    place: str
    field: str
    key: bool
    colour: str
    job: str
    found: str
    why: str


class RoomOfMotor(TypedDict):
    """What a motor's longest line takes in the queue of its axis, in bytes.

    A `safe` line is in the queue as a whole before it begins; another one needs the host.
    """

    motor: str
    longest_bytes: int
    queue_bytes: int
    safe: bool


class ComparedJob(TypedDict):
    """A job compared with the machine: `verdict` is green, amber or red."""

    job: str
    id: str
    verdict: str
    accepted: bool
    fields: list[ComparedField]
    room: list[RoomOfMotor]


@operation("job check")
class JobCheck(Compares):
    """Compare a job with the machine file of today, and with what the boards hold.

    The job is proved first, byte by byte. Exit status 0 green: the machine is as it was when the
    job was made, or differs in names alone; 1 amber: it differs, and a person has to agree; 2 red:
    the job must not be printed. 3: the file is damaged.
    """

    result = ComparedJob
    needs_machine = True

    job: Path = job_file()
    boards: bool = flag("Compare with the boards too, at the ports of the machine file.")
    port: str | None = option(TEXT, "Compare with the boards on this port, too.")
    timeout: float | None = shared.timeout()
    accept_amber: bool = flag("Accept what is amber: the exit status is then 0.")
    all_fields: bool = flag("Also show equal fields that are not key fields.", "--all")

    def run(self, desk: Desk) -> Result:
        """Read the job and compare it."""
        from pixstep.jobs import comparison, judging

        found, today = read(self.job), buses.today(desk.facts)
        machine = today.tables
        rows = comparison.with_machine(found, today)
        rows += self._on_boards(desk, found, machine)
        desk.say(judging.apart(found, machine))
        worst = comparison.verdict(rows).word
        accepted = self.accept_amber and worst == "amber"
        rooms = ((name, judging.room(found, machine, name)) for name in found.motors
                 if name in machine.motors)  # fmt: skip
        data: ComparedJob = {
            "job": str(self.job),
            "id": found.header.id,
            "verdict": worst,
            "accepted": accepted,
            "fields": [_field(row) for row in rows],
            "room": [
                {
                    "motor": name, "longest_bytes": one.longest_bytes,
                    "queue_bytes": one.queue_bytes, "safe": one.safe,
                }
                for name, one in rooms
            ],
        }  # fmt: skip
        status = FINE if accepted else _STATUSES[worst]
        return Result(data, partial(_write, data, self.all_fields), status)

    def _on_boards(self, desk: Desk, job: Job, machine: MachineFile) -> list[ComparisonRow]:
        """Return the rows of all boards of the job, if they are asked."""
        if desk.link is None and self.port is None and not self.boards:
            return []
        with buses.opened(desk, machine, self.port, self.timeout) as bus_of:
            return buses.compared(job, machine, bus_of)


def _field(row: ComparisonRow) -> ComparedField:
    return cast("ComparedField", row.told())


def _write(data: ComparedJob, all_fields: bool, page: Page) -> None:
    """Write the table: what differs, key fields, all of them if asked; then the verdict."""
    shown = [one for one in data["fields"] if all_fields or one["key"] or one["colour"] != "green"]
    table = new_table("", "field", "in the job", "found", "", "why")
    for column in table.columns:
        column.justify = "left"
        column.no_wrap = False
    for one in shown:
        mark = KEY_MARK if one["key"] else ""
        style = STYLES[one["colour"]] + (" bold" if one["key"] else "")
        name = one["field"] if one["place"].endswith(".toml") else f"{one['place']}: {one['field']}"
        table.add_row(mark, name, one["job"], one["found"], one["colour"], one["why"], style=style)
    page.draw(table, wide=True)
    page.tell(LEGEND)
    left = len(data["fields"]) - len(shown)
    if left:
        page.tell(AskedText("{left} fields more are equal ({all} shows them)", left=left))
    for room in data["room"]:
        page.tell(_room_text(room))
    page.tell(page.styled(_verdict_text(data), bold=True))


def _room_text(room: RoomOfMotor) -> str:
    takes = f"longest line {room['longest_bytes']} bytes, the queue has {room['queue_bytes']}"
    if room["safe"]:
        return f"motor {room['motor']}: safe, each line is in its queue before it begins ({takes})"
    return f"motor {room['motor']}: exposed to the host, which feeds lines as they move ({takes})"


def _verdict_text(data: ComparedJob) -> str:
    verdict = data["verdict"]
    count = sum(one["colour"] == verdict for one in data["fields"])
    differences = f"{count} difference{'' if count == 1 else 's'}"
    if verdict == "green":
        return f"{data['job']}: green: the machine is as it was when the job was made"
    if verdict == "red":
        return f"{data['job']}: red: {differences} by which the job must not be printed"
    agreed = AskedText("accepted" if data["accepted"] else "{accept_amber} agrees to them")
    text = f"{data['job']}: amber: {differences}"
    return AskedText("{text}: {agreed}", text=text, agreed=agreed)
