# SPDX-License-Identifier: MIT
"""One record at work: its values, and what one event has brought about so far.

The values of all fields are attributes in small letters: `values.val` is the field VAL. What
clients are told is in the journal: each monitored field whose value differs from what they know.
"""

from copy import copy
from dataclasses import dataclass, field, replace

from pixstep.motor_record.catalogue import FIELDS, MONITOR_ORDER
from pixstep.motor_record.field import Value
from pixstep.motor_record.traffic import MotorCommand, Post, Verb


class Values:
    """All fields of one record. Menus are numbers, buttons and flags are 0 and 1."""

    val: float
    dval: float
    rval: int
    rlv: float
    twv: float
    twf: int
    twr: int
    lval: float
    ldvl: float
    lrvl: int
    lrlv: float
    rbv: float
    drbv: float
    rrbv: int
    rmp: int
    rep: int
    rvel: int
    diff: float
    rdif: int
    off: float
    foff: int
    fof: int
    vof: int
    dir: int
    set: int
    sset: int
    suse: int
    igset: int
    sync: int
    mres: float
    eres: float
    rres: float
    srev: int
    urev: float
    ueip: int
    urip: int
    hlm: float
    llm: float
    dhlm: float
    dllm: float
    rhlm: float
    rllm: float
    lvio: int
    hls: int
    lls: int
    rhls: int
    rlls: int
    velo: float
    vbas: float
    vmax: float
    bvel: float
    jvel: float
    hvel: float
    s: float
    sbas: float
    smax: float
    sbak: float
    accl: float
    accs: float
    accu: int
    bacc: float
    jar: float
    bdst: float
    frac: float
    rdbd: float
    spdb: float
    rcnt: int
    rtry: int
    rmod: int
    miss: int
    dly: float
    ntm: int
    ntmf: int
    stop: int
    spmg: int
    homf: int
    homr: int
    jogf: int
    jogr: int
    stup: int
    cnen: int
    pcof: float
    icof: float
    dcof: float
    proc: int
    dmov: int
    movn: int
    msta: int
    mip: int
    cdir: int
    tdir: int
    athm: int
    pp: int
    lspg: int
    stat: int
    sevr: int
    udf: int
    hlsv: int
    hihi: float
    high: float
    low: float
    lolo: float
    hhsv: int
    hsv: int
    lsv: int
    llsv: int
    out: str
    rdbl: str
    dol: str
    omsl: int
    rlnk: str
    stoo: str
    dinp: str
    rinp: str
    desc: str
    egu: str
    prec: int
    hopr: float
    lopr: float
    mdel: float
    adel: float
    mlst: float
    alst: float
    vers: float
    card: int
    rstm: int
    lock: int
    init: str
    prem: str
    post: str
    disp: int
    disa: int
    disv: int

    def __init__(self) -> None:
        """Give every field its default."""
        for one in FIELDS.values():
            self.write(one.name, one.taken(one.default))

    def write(self, name: str, value: Value) -> None:
        """Give the field `name` a value of its own type."""
        setattr(self, FIELDS[name].attribute, value)

    def read(self, name: str) -> Value:
        """Return the value of the field `name`."""
        value: Value = getattr(self, FIELDS[name].attribute)
        return value


_NAMES = tuple(FIELDS)
_RANK = {name: rank for rank, name in enumerate(MONITOR_ORDER)}


class MonitorJournal:
    """Compares the values with those last told. RBV has dead bands of its own.

    This is done after every processing, so that it must be quick: what is known has the order of
    the values, and the two are compared in one pass.
    """

    def __init__(self, values: Values) -> None:
        self._values = values
        self._known: dict[str, Value | None] = dict(vars(values))
        self._posts: list[Post] = []

    def post(self, name: str) -> None:
        """Tell the value of a field now, whether or not it changed."""
        value = self._values.read(name)
        self._known[FIELDS[name].attribute] = value
        self._posts.append(Post(name, value))

    def doubt(self, name: str) -> None:
        """Forget what clients know of a field: it is told with the next changes."""
        self._known[FIELDS[name].attribute] = None

    def post_changes(self) -> None:
        """Tell all that changed since the last time, in the order of the record."""
        for name in sorted(filter(_RANK.__contains__, self._changed()), key=_RANK.__getitem__):
            if name != "RBV" or self._worth_telling():
                self.post(name)

    def take(self) -> tuple[Post, ...]:
        """Return what was told since the last time, and forget it."""
        taken, self._posts = tuple(self._posts), []
        return taken

    def _changed(self) -> list[str]:
        pairs = zip(_NAMES, vars(self._values).values(), self._known.values(), strict=True)
        return [name for name, now, known in pairs if now != known]

    def _worth_telling(self) -> bool:
        """True if RBV left one of its dead bands, or has none."""
        v = self._values
        if v.mdel == 0 and v.adel == 0:
            return True
        shown = v.mdel == 0 or abs(v.mlst - v.rbv) > v.mdel
        kept = v.adel == 0 or abs(v.alst - v.rbv) > v.adel
        if shown and v.mdel != 0:
            v.mlst = v.rbv
        if kept and v.adel != 0:
            v.alst = v.rbv
        return shown or kept


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
