# SPDX-License-Identifier: MIT
"""One record at work: its values, and what one event has brought about so far."""

from copy import copy
from dataclasses import dataclass, field, replace

from pixstep.motor_record.model.journal import MonitorJournal
from pixstep.motor_record.model.values import Values
from pixstep.motor_record.traffic import MotorCommand, Verb


@dataclass
class InputLink:
    """What an input link gives. `value` is None while what it reads is dead."""

    value: float | None = None
    exists: bool = False


@dataclass
class State:
    """All that a record knows between two events, and what the present one has asked for."""

    v: Values = field(default_factory=Values)
    journal: MonitorJournal = field(init=False)
    commands: list[MotorCommand] = field(default_factory=list)
    delay_s: float | None = None
    """The settling time that this event has begun."""
    rdbl: InputLink = field(default_factory=InputLink)
    dol: InputLink = field(default_factory=InputLink)
    by_write: bool = False
    """A client's write made the record process."""
    status_for_client: bool = False
    """The status that STUP awaits was asked for by a client."""
    resolution_written: bool = False
    """MRES, ERES or UEIP changed, and the record has not acted on that yet."""

    def __post_init__(self) -> None:
        self.journal = MonitorJournal(self.v)

    def twin(self) -> "State":
        """Return a record in the same state, which what happens to this one does not touch."""
        return State(v=copy(self.v), rdbl=replace(self.rdbl), dol=replace(self.dol))

    def ask(self, verb: Verb, argument: float | None = None) -> None:
        """Ask the motor for one thing."""
        self.commands.append(MotorCommand(verb, argument))

    def has(self, *bits: int) -> bool:
        """True if any of these bits of MIP is set."""
        return any(self.v.mip & bit for bit in bits)
