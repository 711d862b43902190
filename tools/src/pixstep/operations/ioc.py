# SPDX-License-Identifier: MIT
"""Motors as motor records of EPICS."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NotRequired, TypedDict

from pixstep import signals
from pixstep.errors import UserError
from pixstep.ioc import names, saved, settings
from pixstep.lazy import lazy
from pixstep.machine import FILE_NAME, VARIABLE
from pixstep.operations import motor_drives
from pixstep.operations.desk import Desk, log_of
from pixstep.operations.kinds import PATH, TEXT
from pixstep.operations.request import Request, flag, operation, option
from pixstep.operations.result import Result

if TYPE_CHECKING:
    from pixstep.ioc import server
    from pixstep.machine.files import MachineFile
else:
    server = lazy("pixstep.ioc.server")


class ServedRecords(TypedDict):
    """What was served: names of records by motors; with --list the names of all PVs."""

    machine: str
    records: dict[str, str]
    pvs: NotRequired[list[str]]


@operation("ioc")
class Ioc(Request):
    """Serve the motors of a machine file as motor records of EPICS (Channel Access).

    Each motor of the file is a record of its own name, all fields of the motor record are PVs:
    PREFIX + NAME + .FIELD. Boards are reached through their server where `pixstep serve` runs. The
    usual variables say where it listens: EPICS_CAS_INTF_ADDR_LIST, EPICS_CA_SERVER_PORT. It ends by
    Ctrl-C, and stops what moves; docs/EPICS.md has the rest.
    """

    result = ServedRecords
    json_rows = "event, or the names as one document"
    needs_machine: ClassVar[bool] = True

    prefix: str | None = option(
        TEXT, "Before the names of all records and PVs.", shown="P:",
        default_text="epics.prefix of the machine file, or none",
    )  # fmt: skip
    simulate: bool = flag("Simulate the boards: nothing moves but a model.")
    port: str | None = option(
        TEXT, "Serial port of all boards; simulated ones have none.", variable="PIXSTEP_PORT",
        default_text="those of the machine file",
    )  # fmt: skip
    state: Path | None = option(
        PATH, "File that keeps settings and positions over a restart.",
        default_text="beside the machine file, machine.ioc.json; none with --simulate",
    )  # fmt: skip
    list: bool = flag("List the names of all PVs, and end.")

    def run(self, desk: Desk) -> Result:
        """Serve until a signal comes."""
        machine = desk.facts.found
        if machine is None:
            raise UserError(
                f"no machine file: --machine FILE, {VARIABLE}, or {FILE_NAME} in this folder "
                f"(`pixstep machine new` begins one)"
            )
        prefix = self.prefix if self.prefix is not None else machine.epics.prefix or ""
        records = settings.record_names(machine, prefix)
        data: dict[str, Any] = {"machine": str(machine.path), "records": records}
        if self.list:
            pvs = names.all_names(prefix, records.values())
            return Result(data | {"pvs": pvs}, "\n".join(pvs))
        self._serve(desk, machine, prefix, records)
        return Result(data, f"{machine.path}: ended", told=True)

    def _serve(
        self, desk: Desk, machine: MachineFile, prefix: str, records: dict[str, str]
    ) -> None:
        kept = saved.Saved(self._state_of(machine))
        make = server.RecordServer  # says before anything is opened that a package is missing
        log = log_of(desk)
        try:
            with motor_drives.opened(machine, self.port, log, simulate=self.simulate) as drives:
                motors = [
                    server.MotorSpec(
                        record, settings.fields_of(machine, machine[name]), drives[name]
                    )
                    for name, record in records.items()
                ]
                found = make(motors, prefix, kept, log)
                try:
                    with signals.until_ctrl_c():
                        found.start()
                        found.wait()
                finally:
                    with signals.ignored():
                        found.close()
        finally:
            log.close()

    def _state_of(self, machine: MachineFile) -> Path | None:
        """Return the file of what is kept, None if nothing is."""
        if self.state or self.simulate:
            return self.state
        return machine.path.with_suffix(".ioc.json")
