# SPDX-License-Identifier: MIT
"""The folder of a simulation, NAME.pxsim: what is finished, and what came of it.

blocks/KEY.parquet   the rows of a block: it is finished. Its name is its content's
edges/KEY.parquet    the edges of a block, where this computer has simulated it
lines.parquet        a row a motor and line of the whole job, once all blocks are finished
simulation.json      what was simulated, and the verdict
"""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pixstep import atomic
from pixstep.errors import AskedText, RefusedError, UserError
from pixstep.jobs.job import Job
from pixstep.jobs.simulated import rows
from pixstep.jobs.simulated.cuts import Cut
from pixstep.jobs.simulated.work import Answer
from pixstep.lazy import lazy, parquet, pyarrow

if TYPE_CHECKING:
    from pyarrow import compute
else:
    compute = lazy("pyarrow.compute")

SUFFIX = ".pxsim"
_BLOCKS, _EDGES, _LINES, _ABOUT = "blocks", "edges", "lines.parquet", "simulation.json"
_WHERE = b"pixstep"  # the metadata of a block's rows: who made them, and where its edges are
_GROUP = 4096  # rows that are written together: each group takes memory until the end
_MARK = b"PAR1"
MOST_FAILED = 20  # lines that are told one by one


@dataclass
class Told:
    """What the rows of all lines say together."""

    failed: int = 0
    first_failed: list[dict[str, Any]] = field(default_factory=list)
    steps: int = 0
    worst: dict[str, float] = field(default_factory=dict)
    hosts: Counter[str] = field(default_factory=Counter)  # blocks by who simulated them
    sha256: str = ""


def _refuse_other(path: Path) -> None:
    """Refuse a folder that holds something else than a simulation, naming the file that says so."""
    try:
        if not any(path.iterdir()):
            return
        about = json.loads((path / _ABOUT).read_text("utf-8"))
    except NotADirectoryError as error:
        raise UserError(f"{path}: {error.strerror}") from None
    except FileNotFoundError:
        if not path.exists():
            return
        why = f"{_ABOUT} is not there"
    except OSError as error:
        why = f"{_ABOUT}: {error.strerror or error}"
    except (ValueError, RecursionError):
        why = f"{_ABOUT} is damaged"
    else:
        if isinstance(about, dict) and {"job", "verdict"} <= about.keys():
            return
        why = f"{_ABOUT} tells of none"
    raise UserError(AskedText(
        "{path}: is the folder of no simulation: {why}: name another one with {out}",
        path=path, why=why,
    ))  # fmt: skip


class SimFolder:
    """A folder of a simulation; nothing is made before it is begun."""

    def __init__(self, path: Path, edges: Path | None = None) -> None:
        """Take a folder. Raises UserError for one that holds something else."""
        _refuse_other(path)
        self.path = path
        place = edges or path / _EDGES
        # "~" is that of whoever simulates.
        self.edges = place if place.parts[:1] == ("~",) else place.absolute()

    @property
    def lines(self) -> Path:
        """The table of all lines."""
        return self.path / _LINES

    def begin(self, about: dict[str, Any]) -> None:
        """Make the folder, without the table of an earlier run, which must not pass for this one's.

        `about` is what is simulated.
        """
        with atomic.told_of(self.path):
            atomic.make_folder(self.path / _BLOCKS, self.path)
            self.lines.unlink(missing_ok=True)
        self.write_about({**about, "verdict": "unfinished"})

    def sweep(self) -> None:
        """Remove the unfinished edges of processes that were ended."""
        atomic.sweep(self.edges.expanduser())

    def write_about(self, about: dict[str, Any]) -> None:
        """Write what was simulated."""
        with atomic.rules(atomic.WriteRules(force=True)):
            atomic.write_json(self.path / _ABOUT, about)

    def has(self, key: str) -> bool:
        """Whether a block is finished, and its edges are there, if they were left here."""
        try:
            where = self._where(key)
            return where["local"] is False or _is_whole(Path(where["edges"]))
        except (UserError, KeyError, TypeError, ValueError):
            return False

    def keep(self, answer: Answer, *, local: bool) -> None:
        """Keep the rows of a block: it is finished then."""
        where = {
            "host": answer.host,
            "edges": answer.edges,
            "seconds": answer.seconds,
            "local": local,
        }
        table = parquet.read_table(pyarrow.BufferReader(answer.rows))
        table = table.replace_schema_metadata({_WHERE: json.dumps(where)})
        sink = pyarrow.BufferOutputStream()
        parquet.write_table(table, sink, compression="zstd", write_statistics=False)
        with atomic.rules(atomic.WriteRules(force=True)):
            atomic.write_bytes(self._rows(answer.key), bytes(sink.getvalue().to_pybytes()))

    def _rows(self, key: str) -> Path:
        return self.path / _BLOCKS / f"{key}.parquet"

    def _where(self, key: str) -> dict[str, Any]:
        path = self._rows(key)
        if not path.is_file():
            raise UserError(f"{path}: is not there")
        try:
            found = parquet.read_schema(path)
        except (pyarrow.ArrowException, OSError):
            raise RefusedError(f"{path}: no rows of a simulation") from None
        if not found.equals(rows.schema()):
            raise RefusedError(f"{path}: no rows of a simulation")
        where: dict[str, Any] = json.loads((found.metadata or {})[_WHERE])
        return where

    def assemble(self, job: Job, cuts: Iterable[Cut]) -> Told:
        """Write the table of all lines from those of the blocks, a few blocks at a time."""
        import hashlib

        told, total = Told(), hashlib.sha256()
        seen: set[str] = set()
        waiting: list[pyarrow.Table] = []
        with (
            atomic.rules(atomic.WriteRules(force=True)), atomic.replacing(self.lines) as path,
            parquet.ParquetWriter(path, _schema(), compression="zstd") as writer,
        ):  # fmt: skip
            for cut in cuts:
                where = self._where(cut.key)
                if cut.key not in seen:
                    told.hosts[where["host"]] += 1
                    seen.add(cut.key)
                table = _of_job(rows.read(self._rows(cut.key)), cut, where)
                _sum_up(told, table)
                for value in table.column("sha256").to_pylist():
                    total.update(value.encode())
                waiting.append(table)
                if sum(one.num_rows for one in waiting) >= _GROUP:
                    writer.write_table(pyarrow.concat_tables(waiting))
                    waiting.clear()
            if waiting:
                writer.write_table(pyarrow.concat_tables(waiting))
        told.sha256 = total.hexdigest()
        return told


def _is_whole(path: Path) -> bool:
    """Return whether a file is Parquet to its end, where its writer puts the mark last."""
    try:
        with path.open("rb") as file:
            file.seek(-len(_MARK), os.SEEK_END)
            return file.read() == _MARK
    except OSError:
        return False


def _schema() -> pyarrow.Schema:
    found = rows.schema()
    for name, kind in (
        ("block", pyarrow.string()), ("in_block", pyarrow.int64()), ("host", pyarrow.string()),
        ("edges", pyarrow.string()),
    ):  # fmt: skip
        found = found.append(pyarrow.field(name, kind))
    return found


def _of_job(table: pyarrow.Table, cut: Cut, where: dict[str, Any]) -> pyarrow.Table:
    """Return the rows of a block with the numbers that its lines have in the job."""
    inside = table.column("line")
    count = table.num_rows
    table = table.replace_schema_metadata(None)
    table = table.set_column(0, "line", compute.add(inside, cut.first - 1))
    for name, values in (
        ("block", pyarrow.repeat(cut.key, count)), ("in_block", inside),
        ("host", pyarrow.repeat(where["host"], count)),
        ("edges", pyarrow.repeat(where["edges"], count)),
    ):  # fmt: skip
        table = table.append_column(name, values)
    return table


_ERRORS = (
    "off_steps", "late_ticks", "edge_error_ticks", "clock_error_ticks", "apart_ticks",
    "load_error_steps",
)  # fmt: skip


def _sum_up(told: Told, table: pyarrow.Table) -> None:
    """Add the rows of a block to what is told of all."""
    told.steps += compute.sum(table.column("steps")).as_py() or 0
    for name in _ERRORS:
        worst = compute.max(compute.abs(table.column(name))).as_py()
        if worst is not None:
            told.worst[name] = max(worst, told.worst.get(name, 0))
    bad = table.filter(compute.equal(table.column("verdict"), rows.FAIL))
    told.failed += len(set(bad.column("line").to_pylist()))
    for row in bad.select(["line", "motor", "reason"]).to_pylist():
        if len(told.first_failed) < MOST_FAILED:
            told.first_failed.append(row)
