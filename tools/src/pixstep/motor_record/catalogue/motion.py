# SPDX-License-Identifier: MIT
"""Fields of speeds, motions, retries and states."""

from pixstep.motor_record.catalogue.rows import (
    button,
    choice,
    flag,
    setting,
)
from pixstep.motor_record.field import FieldType, RecordField
from pixstep.motor_record.menus import (
    ACCELERATION,
    ALARM,
    ENABLE,
    NO_YES_CAPITALS,
    RETRY_MODE,
    SEVERITY,
    SPMG,
    STATUS_UPDATE,
)

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

TABLE = SPEEDS + BACKLASH_AND_RETRIES + BUTTONS + STATES + ALARMS
