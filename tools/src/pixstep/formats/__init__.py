# SPDX-License-Identifier: MIT
"""File formats: PRN profiles, CSV and CSB profiles and motion files.

`findings` collects what is wrong, `records` are bytes, line ends and columns, and the PRN,
`header` the four lines, `motion` the CSV and the CSB, `files` reads and writes whole files,
`convert` turns one into another, `describe` says what is in one.
"""

from pixstep.formats.files import (
    encode,
    read_any,
    read_csv,
    read_motion,
    read_prn,
    write_csv,
    write_motion,
    write_prn,
)
from pixstep.formats.header import ProfileHeader, hz_text
from pixstep.formats.motion import FileBlock, MotionFile, of_lines
from pixstep.formats.records import PrnFile

__all__ = [
    "FileBlock",
    "MotionFile",
    "PrnFile",
    "ProfileHeader",
    "encode",
    "hz_text",
    "of_lines",
    "read_any",
    "read_csv",
    "read_motion",
    "read_prn",
    "write_csv",
    "write_motion",
    "write_prn",
]
