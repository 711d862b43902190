# SPDX-License-Identifier: MIT
"""The values of all fields, as attributes in small letters: `values.val` is the field VAL."""

from pixstep.motor_record.catalogue import FIELDS
from pixstep.motor_record.field import Value


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
        for field in FIELDS.values():
            self.write(field.name, field.taken(field.default))

    def write(self, name: str, value: Value) -> None:
        """Give the field `name` a value of its own type."""
        setattr(self, FIELDS[name].attribute, value)

    def read(self, name: str) -> Value:
        """Return the value of the field `name`."""
        value: Value = getattr(self, FIELDS[name].attribute)
        return value
