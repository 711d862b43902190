# SPDX-License-Identifier: MIT
"""A job compared with a machine that has changed: each field alone, all pairs, boards unlike it.

The rows, colours, marks, the text and the exit status are judged by a model that knows nothing of
the product (`machine_changes`); and what a job's play is when the machine's differs, by edges.
"""

from __future__ import annotations

import json
import random
import re
import tempfile
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import combinations
from pathlib import Path
from typing import Any

from click.testing import CliRunner

from pixstep import formats, natives, ops
from pixstep.board.errors import BoardError
from pixstep.cli.main import main
from pixstep.errors import RefusedError
from pixstep.progress import Progress, unseen
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import SimOptions
from pixstep_dev.jobs import machine_changes as model
from pixstep_dev.jobs.machine_changes import AMBER, GREEN, GREY, RED, Expected, MachineChange

EDGES = 17_086  # of a line at 1,000 steps/px with 8 pixels at that speed and 250 steps of play
_WIDTH = 26
_MARK = "\N{BLACK DIAMOND}"
_RAMP = [8, 16, 24, 32, 38, 44, 128, 172, 256, 384, 512, 640, 768, 896, 1024]
# Of a board: what is set, its row, the colour, whether a key field, whether the job has settings.
BOARDS = (
    ("pixel_hz=31", "pixel_hz", AMBER, True, False),
    ("divider=2", "divider", AMBER, True, False),
    ("sync=1", "sync", AMBER, False, False),
    ("gate_edges=90", "gate_edges", AMBER, False, False),
    ("backlash_policy=1", "backlash_policy", AMBER, False, False),
    ("dir_setup_us=30", "dir_setup_us", GREY, False, False),
    ("dir_setup_us=30", "dir_setup_us", AMBER, False, True),
    ("bus_timeout_ms=900", "bus_timeout_ms", AMBER, False, True),
)


@dataclass(frozen=True)
class JobComparePlan:
    """How many of the pairs are tried, drawn by chance; None is all of them."""

    pairs: int | None = None
    seed: int = 1


@dataclass
class JobCompareOutcome:
    """What was found."""

    alone: int = 0
    pairs: int = 0
    refused: int = 0
    boards: int = 0
    rows: int = 0
    edges: int = 0
    complaints: list[str] = field(default_factory=list)


def run(plan: JobComparePlan, show: Progress = unseen) -> JobCompareOutcome:
    """Compare a job with changed machines, and with boards that are set otherwise."""
    outcome = JobCompareOutcome()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        _make(folder)
        pairs = [one for one in combinations(model.CHANGES, 2) if not model.exclude(*one)]
        if plan.pairs is not None:
            pairs = random.Random(plan.seed).sample(pairs, plan.pairs)
        judge = _Judge(folder, outcome)
        total = len(pairs) + 2 * len(model.CHANGES)
        for number, one in enumerate(model.CHANGES, 1):
            judge.alone(one)
            show(2 * number / total)
        for number, two in enumerate(pairs, 2 * len(model.CHANGES) + 1):
            judge.pair(two)
            show(number / total)
        judge.boards()
        judge.edges()
    return outcome


def _make(folder: Path) -> None:
    """Write the machine, its profiles, and a job of two lines whose ends are at 1,000 steps/px."""
    speeds = {"line.PRN": _RAMP, "same.PRN": _RAMP, "other.PRN": [*_RAMP[:-2], 900, 1024]}
    for name, ramp in speeds.items():
        formats.write_prn(folder / name, ramp)
    formats.write_csv(folder / "move.csv", [4, 12, 20, 28])
    formats.write_csv(folder / "slow.csv", [4, 8, 12])
    machine = folder / "machine.toml"
    machine.write_text(model.MACHINE)
    ops.job_make(
        image_size="4x1", scan="M39=1000", turn="M40=60", lead_in=2, lead_out=2,
        output=folder / "a.pxjob", machine=machine,
    )  # fmt: skip


@dataclass(frozen=True)
class _Judge:
    """A folder with the job, and where complaints go."""

    folder: Path
    outcome: JobCompareOutcome

    def alone(self, change: MachineChange) -> None:
        """Judge one change by the command: its JSON, its text, its exit status."""
        self._write([change])
        wanted = model.expected([change])
        done = self._command("--json")
        self._rows(change.name, json.loads(done.stdout), wanted)
        colour = model.verdict(wanted.values())
        for more, status in (((), model.STATUS[colour]), (("--accept-amber",), _agreed(colour))):
            done = self._command(*more)
            if done.exit_code != status:
                self._complain(change.name, f"exit status {done.exit_code}, not {status}")
            self._text(change.name, done.stdout, wanted, colour, bool(more))
        self.outcome.alone += 1

    def pair(self, two: tuple[MachineChange, MachineChange]) -> None:
        """Judge two changes by the operation."""
        name = " and ".join(one.name for one in two)
        self._write(two)
        wanted = model.expected(two)
        try:
            done = ops.job_check(self.folder / "a.pxjob", machine=self.folder / "machine.toml")
        except RefusedError as error:
            if model.NO_AXIS not in str(error) or not model.lacks_axis(two):
                self._complain(name, f"refused: {error}")
            self.outcome.refused += 1
            return
        if model.lacks_axis(two):
            self._complain(name, f"not refused: {model.NO_AXIS}")
        self._rows(name, done.data, wanted)
        colour = model.verdict(wanted.values())
        if done.status != model.STATUS[colour]:
            self._complain(name, f"exit status {done.status}, not {model.STATUS[colour]}")
        self.outcome.pairs += 1

    def _write(self, changes: list[MachineChange] | tuple[MachineChange, ...]) -> None:
        (self.folder / "machine.toml").write_text(model.text_of(changes))

    def _command(self, *more: str) -> Any:
        words = ["job", "check", f"{self.folder}/a.pxjob", "--machine",
                 f"{self.folder}/machine.toml", *more]  # fmt: skip
        return CliRunner().invoke(main, words)

    def _rows(self, name: str, data: Any, wanted: dict[str, Expected]) -> None:
        """Judge rows: those that differ are those wanted, with colour, mark and both values."""
        found = {one["field"]: one for one in data["fields"] if one["colour"] != GREEN}
        self.outcome.rows += len(data["fields"])
        for what in sorted({*found} ^ {*wanted}):
            has = "is missing" if what in wanted else f"differs: {found[what]}"
            self._complain(name, f"{what} {has}")
        for what in {*found} & {*wanted}:
            row, one = wanted[what], found[what]
            told = (one["colour"], one["key"], one["job"], one["found"])
            meant = (row.colour, row.key, row.job or one["job"], row.found or one["found"])
            if told != meant or not one["why"]:
                self._complain(name, f"{what}: {told}, {one['why']!r}, not {meant}")
        if data["verdict"] != model.verdict(wanted.values()):
            self._complain(name, f"the verdict is {data['verdict']}")

    def _text(
        self, name: str, text: str, wanted: dict[str, Expected], colour: str, accepts: bool
    ) -> None:
        """Judge a page: each row that differs with colour and mark, the legend, the last line."""
        squeezed = " ".join(text.split())
        for row in wanted.values():
            begin = re.escape(row.field[:_WIDTH])  # a longer one goes on in the next row of text
            begins = rf"^ *{_MARK if row.key else ''} *{begin}.* {row.colour} "
            if not re.search(begins, text, re.MULTILINE):
                self._complain(name, f"{row.field} has no row with its mark and colour")
        if f"{_MARK} key field: it decided the counts" not in squeezed:
            self._complain(name, "no legend")
        last = text.rstrip().splitlines()[-1]
        if not last.startswith(f"{self.folder}/a.pxjob: {colour}"):
            self._complain(name, f"the last line is {last!r}")
        if (colour == AMBER and accepts) != last.endswith("accepted"):
            self._complain(name, f"the last line is {last!r}")

    def boards(self) -> None:
        """Judge boards that are not as the job or the file has them."""
        (self.folder / "machine.toml").write_text(model.MACHINE)
        plain = self.folder / "a.pxjob"
        with _bus() as link:
            ops.board_settings_export(self.folder / "main.toml", link=link)
        self._make_with_settings()
        for assigned, what, colour, key, copied in BOARDS:
            name = f"board {assigned}{' with the job' * copied}"
            with _bus() as link:
                self._clock_of_job(link)
                ops.board_set((assigned,), link=link)
                done = ops.job_check(
                    self.folder / "b.pxjob" if copied else plain,
                    machine=self.folder / "machine.toml", link=link,
                )  # fmt: skip
            self._board(name, done, {("board main", what): (colour, key)})
        with _bus("uno") as link:
            done = ops.job_check(plain, machine=self.folder / "machine.toml", link=link)
        self._board("another kind of board", done, {("board main", "kind"): (RED, True)}, more=True)
        with _bus("mega") as link:
            ops.board_set(("unit_address=9",), link=link)
            done = ops.job_check(plain, machine=self.folder / "machine.toml", link=link)
        self._board("no board there", done, {("board main", "board"): (RED, False)})

    def _make_with_settings(self) -> None:
        ops.job_make(
            image_size="4x1", scan="M39=1000", turn="M40=60", lead_in=2, lead_out=2,
            output=self.folder / "b.pxjob", machine=self.folder / "machine.toml",
            settings=(f"main={self.folder / 'main.toml'}",),
        )  # fmt: skip

    def _clock_of_job(self, link: SimLink) -> None:
        ops.board_set(("pixel_hz=30", "divider=1", "sync=2"), link=link)

    def _board(
        self, name: str, done: Any, wanted: dict[tuple[str, str], tuple[str, bool]],
        more: bool = False,
    ) -> None:  # fmt: skip
        self.outcome.boards += 1
        found = {
            (one["place"], one["field"]): (one["colour"], one["key"])
            for one in done["fields"] if one["colour"] != GREEN
        }  # fmt: skip
        right = all(found.get(key) == one for key, one in wanted.items()) if more else (
            found == wanted)  # fmt: skip
        if not right:
            self._complain(name, f"{found}, not {wanted}")
        worst = max((colour for colour, _ in found.values()), key=_worse, default=GREEN)
        if done.status != model.STATUS[worst]:
            self._complain(name, f"exit status {done.status}: {worst}")

    def edges(self) -> None:
        """Print the job though the machine's play is another: the job's is sent."""
        text = model.MACHINE.replace('"250 steps"', '"100 steps"')
        (self.folder / "machine.toml").write_text(text)
        with _bus() as link:
            given: dict[str, Any] = {
                "machine": self.folder / "machine.toml", "folder": self.folder / "a.pxrun",
                "link": link,
            }  # fmt: skip
            try:
                ops.job_run(self.folder / "a.pxjob", **given)
                self._complain("play 100 today", "printed though nobody agreed")
            except RefusedError as error:
                if "backlash" not in str(error) or "amber" not in str(error):
                    self._complain("play 100 today", f"refused by {error}")
            before = link.simulator.count(0, 0)
            try:
                ops.job_run(self.folder / "a.pxjob", accept_amber=True, **given)
            except BoardError as error:
                self._complain("play 100 today", str(error))
            self.outcome.edges = link.simulator.count(0, 0)
        if before or self.outcome.edges != EDGES:
            self._complain(
                "play 100 today", f"{before} edges before, {self.outcome.edges} in all, not {EDGES}"
            )

    def _complain(self, name: str, text: str) -> None:
        self.outcome.complaints.append(f"{name}: {text}")


def _agreed(colour: str) -> int:
    return 0 if colour == AMBER else model.STATUS[colour]


def _worse(colour: str) -> int:
    return (GREEN, GREY, AMBER, RED).index(colour)


def _bus(kind: str = "mega") -> SimLink:
    return SimLink(SimOptions([(kind, natives.image(kind))], Fraction(30)))
