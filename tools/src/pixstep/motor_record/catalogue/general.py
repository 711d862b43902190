# SPDX-License-Identifier: MIT
"""Fields of links, display and the device, and the fields that are not served."""

from collections.abc import Mapping

from pixstep.motor_record.catalogue.rows import choice, flag, link, reading, setting, text
from pixstep.motor_record.field import FieldType, RecordField
from pixstep.motor_record.menus import NO_YES_CAPITALS, OUTPUT_MODE, RESTORE

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

TABLE = LINKS + DISPLAY + DEVICE

NOT_SERVED: Mapping[str, str] = {
    "RES": "the record does not have it any more: MRES",
    "MMAP": "says inside the C record what is to be posted: here that is a comparison",
    "NMAP": "as MMAP",
    "CBAK": "an address inside the C record: the timer of DLY is the server's here",
}
"""Fields of the record that are not there, and why. What every record of EPICS has and the model
does not need (SCAN, FLNK, ASG and so on) is the server's."""
