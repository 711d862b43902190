# SPDX-License-Identifier: MIT
"""All fields of the motor record by what they are for, and the order in which they are posted.

First those of targets, positions and coordinates, then those of speeds, motions, retries and
states, then those of links, display and the device, and the fields that are not served.
"""

from collections.abc import Mapping
from typing import Final

from pixstep.motor_record.field import (
    ACCELERATION,
    ALARM,
    DIRECTION,
    ENABLE,
    NO_YES,
    NO_YES_CAPITALS,
    OFFSET,
    OUTPUT_MODE,
    RESTORE,
    RETRY_MODE,
    SEVERITY,
    SPMG,
    STATUS_UPDATE,
    USE_SET,
    FieldType,
    RecordField,
    button,
    choice,
    count,
    counted,
    flag,
    link,
    reading,
    setting,
    text,
)

USER = ("LLM", "HLM")
DIAL = ("DLLM", "DHLM")
RAW = ("RLLM", "RHLM")

TARGETS = (
    setting("VAL", meaning="target, user coordinates", unit="EGU", processes=True, limits=USER),
    setting("DVAL", meaning="target, dial coordinates", unit="EGU", processes=True, limits=DIAL),
    count("RVAL", meaning="target, raw", unit="steps", processes=True, limits=RAW),
    setting("RLV", meaning="distance to move by, 0 afterwards", unit="EGU", processes=True),
    setting("TWV", meaning="distance of a tweak", unit="EGU"),
    button("TWF", meaning="tweak: move by TWV", processes=True),
    button("TWR", meaning="tweak: move by -TWV", processes=True),
    reading("LVAL", meaning="VAL of the last move", unit="EGU", monitored=False),
    reading("LDVL", meaning="DVAL of the last move", unit="EGU", monitored=False),
    counted("LRVL", meaning="RVAL of the last move", unit="steps", monitored=False),
    reading("LRLV", meaning="RLV of the last move", unit="EGU", monitored=False),
)

READBACKS = (
    reading("RBV", meaning="position, user coordinates", unit="EGU", limits=USER),
    reading("DRBV", meaning="position, dial coordinates", unit="EGU", limits=DIAL),
    counted("RRBV", meaning="position, raw", unit="steps", limits=RAW),
    counted("RMP", meaning="position as the motor counts", unit="steps"),
    counted("REP", meaning="position as the encoder counts", unit="counts"),
    counted("RVEL", meaning="raw speed", unit="steps/s"),
    reading("DIFF", meaning="DVAL - DRBV", unit="EGU"),
    counted("RDIF", meaning="DIFF in steps", unit="steps"),
)

COORDINATES = (
    setting("OFF", meaning="user = dial x direction + OFF", unit="EGU", processes=True),
    choice(
        "FOFF",
        menu=OFFSET,
        meaning="does setting a position change OFF or VAL",
        group="coordinates",
    ),
    button("FOF", meaning="write: FOFF becomes Frozen", monitored=False),
    button("VOF", meaning="write: FOFF becomes Variable", monitored=False),
    choice("DIR", menu=DIRECTION, meaning="direction of user against dial", processes=True),
    choice("SET", menu=USE_SET, meaning="targets move (Use) or say where the axis is (Set)"),
    button("SSET", meaning="write: SET becomes Set", monitored=False),
    button("SUSE", meaning="write: SET becomes Use", monitored=False),
    button("IGSET", meaning="SET has no effect"),
    button("SYNC", meaning="write 1: targets become readbacks", processes=True),
)

RESOLUTION = (
    setting("MRES", meaning="one step", unit="EGU", processes=True),
    setting("ERES", meaning="one count of the encoder", unit="EGU", processes=True),
    setting("RRES", meaning="one unit of what RDBL gives", unit="EGU"),
    count("SREV", meaning="steps of a revolution", unit="steps/rev", default=200, processes=True),
    setting("UREV", meaning="travel of a revolution", unit="EGU/rev", processes=True),
    choice("UEIP", menu=NO_YES, meaning="positions from the encoder", processes=True),
    choice("URIP", menu=NO_YES, meaning="positions from the link RDBL", processes=True),
)

LIMITS = (
    setting("HLM", meaning="high limit, user", unit="EGU", processes=True),
    setting("LLM", meaning="low limit, user", unit="EGU", processes=True),
    setting("DHLM", meaning="high limit, dial; with DLLM 0: none", unit="EGU", processes=True),
    setting("DLLM", meaning="low limit, dial", unit="EGU", processes=True),
    reading("RHLM", meaning="high limit, raw", unit="steps"),
    reading("RLLM", meaning="low limit, raw", unit="steps"),
    flag("LVIO", meaning="a target or the position violates a limit", default=1),
    flag("HLS", meaning="high limit switch, user direction"),
    flag("LLS", meaning="low limit switch, user direction"),
    flag("RHLS", meaning="high limit switch, raw direction"),
    flag("RLLS", meaning="low limit switch, raw direction"),
)

POSITION = TARGETS + READBACKS + COORDINATES + RESOLUTION + LIMITS


PER_SECOND = "EGU/sec"
TURNS = "rev/sec"

SPEEDS = (
    setting("VELO", meaning="speed of moves", unit=PER_SECOND, limits=("VBAS", "VMAX")),
    setting("VBAS", meaning="lowest speed", unit=PER_SECOND),
    setting("VMAX", meaning="highest speed; 0: none", unit=PER_SECOND),
    setting("BVEL", meaning="speed of the approach against backlash", unit=PER_SECOND),
    setting("JVEL", meaning="speed of jogs", unit=PER_SECOND),
    setting("HVEL", meaning="speed of homing", unit=PER_SECOND),
    setting("S", meaning="VELO in revolutions", unit=TURNS),
    setting("SBAS", meaning="VBAS in revolutions", unit=TURNS),
    setting("SMAX", meaning="VMAX in revolutions", unit=TURNS),
    setting("SBAK", meaning="BVEL in revolutions", unit=TURNS),
    setting("ACCL", meaning="time from VBAS to VELO", unit="sec", default=0.2),
    setting("ACCS", meaning="acceleration of moves", unit="EGU/sec^2"),
    choice("ACCU", menu=ACCELERATION, meaning="which of ACCL and ACCS stays as VELO changes"),
    setting("BACC", meaning="time from VBAS to BVEL", unit="sec", default=0.5),
    setting("JAR", meaning="acceleration of jogs", unit="EGU/s/s"),
)

BACKLASH_AND_RETRIES = (
    setting("BDST", meaning="backlash: the last approach goes in its direction", unit="EGU"),
    RecordField("FRAC", FieldType.FLOAT, "part of a distance that one move covers", default=1.0),
    setting("RDBD", meaning="a move ends well within this", unit="EGU"),
    setting("SPDB", meaning="no move to a target within this", unit="EGU"),
    flag("RCNT", meaning="retries made"),
    button("RTRY", meaning="most retries; 0: none", default=10),
    choice("RMOD", menu=RETRY_MODE, meaning="how much of the distance a retry covers"),
    flag("MISS", meaning="the retries did not reach the target"),
    setting("DLY", meaning="wait after each motion, before the position counts", unit="sec"),
    choice("NTM", menu=NO_YES_CAPITALS, meaning="a target behind stops the move", default=1),
    RecordField("NTMF", FieldType.USHORT, "NTM: that far behind, in BDST + RDBD", default=2),
)

BUTTONS = (
    button("STOP", meaning="write 1: stop, the target becomes the position", processes=True),
    choice("SPMG", menu=SPMG, meaning="stop, pause, one move, go", default=3, processes=True),
    button("HOMF", meaning="write 1: find the home switch, forwards", processes=True),
    button("HOMR", meaning="write 1: find the home switch, backwards", processes=True),
    button("JOGF", meaning="move forwards while this is 1", processes=True),
    button("JOGR", meaning="move backwards while this is 1", processes=True),
    choice("STUP", menu=STATUS_UPDATE, meaning="write ON: ask for a status", processes=True),
    choice("CNEN", menu=ENABLE, meaning="hold the position in a closed loop", processes=True),
    setting("PCOF", meaning="proportional gain, 0 to 1"),
    setting("ICOF", meaning="integral gain, 0 to 1"),
    setting("DCOF", meaning="derivative gain, 0 to 1"),
    RecordField("PROC", FieldType.UCHAR, "write: process", processes=True, monitored=False),
)

STATES = (
    flag("DMOV", meaning="done: the motor rests as far as the record asked", default=1),
    flag("MOVN", meaning="the motor moves"),
    RecordField("MSTA", FieldType.ULONG, "status bits of the motor", writable=False),
    RecordField("MIP", FieldType.USHORT, "what is in progress, bits", writable=False),
    flag("CDIR", meaning="raw direction that was asked for"),
    flag("TDIR", meaning="raw direction of the last travel"),
    flag("ATHM", meaning="the home switch is active"),
    flag("PP", meaning="something follows when the motor rests", monitored=False),
    choice(
        "LSPG",
        menu=SPMG,
        meaning="SPMG as acted upon",
        default=3,
        writable=False,
        monitored=False,
    ),
)

ALARMS = (
    choice("STAT", menu=ALARM, meaning="alarm", writable=False),
    choice("SEVR", menu=SEVERITY, meaning="severity of the alarm", writable=False),
    RecordField("UDF", FieldType.UCHAR, "VAL has no value yet", writable=False, monitored=False),
    choice("HLSV", menu=SEVERITY, meaning="severity at a limit", processes=True),
    setting("HIHI", meaning="highest; raises no alarm", unit="EGU", processes=True),
    setting("HIGH", meaning="high; raises no alarm", unit="EGU", processes=True),
    setting("LOW", meaning="low; raises no alarm", unit="EGU", processes=True),
    setting("LOLO", meaning="lowest; raises no alarm", unit="EGU", processes=True),
    choice("HHSV", menu=SEVERITY, meaning="of HIHI; no effect", processes=True),
    choice("HSV", menu=SEVERITY, meaning="of HIGH; no effect", processes=True),
    choice("LSV", menu=SEVERITY, meaning="of LOW; no effect", processes=True),
    choice("LLSV", menu=SEVERITY, meaning="of LOLO; no effect", processes=True),
)

MOTION = SPEEDS + BACKLASH_AND_RETRIES + BUTTONS + STATES + ALARMS


VERSION = 7.4

LINKS = (
    link("OUT", meaning="what moves the motor"),
    link("RDBL", meaning="another position: used with URIP"),
    link("DOL", meaning="a target from elsewhere: used with OMSL"),
    choice("OMSL", menu=OUTPUT_MODE, meaning="targets by clients, or from DOL"),
    link("RLNK", meaning="kept; nothing is written there"),
    link("STOO", meaning="kept; for a soft motor only"),
    link("DINP", meaning="kept; for a soft motor only"),
    link("RINP", meaning="kept; for a soft motor only"),
)

DISPLAY = (
    text("DESC", default="", meaning="what the axis is", size=41),
    text("EGU", default="", meaning="unit of positions", size=16),
    RecordField("PREC", FieldType.SHORT, "digits after the point"),
    setting("HOPR", meaning="highest for displays", unit="EGU"),
    setting("LOPR", meaning="lowest for displays", unit="EGU"),
    setting("MDEL", meaning="RBV is posted when it changed by more than this", unit="EGU"),
    setting("ADEL", meaning="as MDEL, for archives", unit="EGU"),
    reading("MLST", meaning="RBV as last posted with MDEL", unit="EGU", monitored=False),
    reading("ALST", meaning="RBV as last posted with ADEL", unit="EGU", monitored=False),
)

DEVICE = (
    RecordField("VERS", FieldType.FLOAT, "version of the record", default=VERSION, writable=False),
    flag("CARD", meaning="number of the card", default=-1),
    choice("RSTM", menu=RESTORE, meaning="does a restart set the position", default=2),
    choice("LOCK", menu=NO_YES_CAPITALS, meaning="kept; for a soft motor only"),
    text("INIT", default="", meaning="kept; the driver takes no texts"),
    text("PREM", default="", meaning="kept; the driver takes no texts"),
    text("POST", default="", meaning="kept; the driver takes no texts"),
    RecordField("DISP", FieldType.UCHAR, "1: clients may not write"),
    RecordField("DISA", FieldType.SHORT, "the record is off where this equals DISV"),
    RecordField("DISV", FieldType.SHORT, "see DISA", default=1),
)

GENERAL = LINKS + DISPLAY + DEVICE

NOT_SERVED: Mapping[str, str] = {
    "RES": "the record does not have it any more: MRES",
    "MMAP": "says inside the C record what is to be posted: here that is a comparison",
    "NMAP": "as MMAP",
    "CBAK": "an address inside the C record: the timer of DLY is the server's here",
}
"""Fields of the record that are not there, and why. What every record of EPICS has and the model
does not need (SCAN, FLNK, ASG and so on) is the server's."""

FIELDS: Final[Mapping[str, RecordField]] = {
    field.name: field for field in POSITION + MOTION + GENERAL
}

# After one processing, as the record does it: what the write of a setting changed beside it comes
# first, DMOV nearly last, so that whoever waits for DMOV has the position.
_LAST_POSTED: Final = (
    *("STAT", "SEVR", "RBV", "RRBV", "DRBV", "DIFF", "RDIF", "MSTA", "CNEN", "VAL", "DVAL"),
    *("RVAL", "TDIR", "MIP", "HLM", "LLM", "SPMG", "RCNT", "RLV", "OFF", "DHLM", "DLLM", "HLS"),
    *("LLS", "RHLS", "RLLS", "ATHM", "MRES", "ERES", "UEIP", "LVIO", "STOP", "SBAS", "SREV"),
    *("UREV", "VELO", "VBAS", "MISS", "MOVN", "DMOV", "STUP", "JOGF", "JOGR", "HOMF", "HOMR"),
)
MONITOR_ORDER: Final = tuple(
    name for name, field in FIELDS.items() if field.monitored and name not in _LAST_POSTED
) + tuple(_LAST_POSTED)
