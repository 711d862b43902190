# SPDX-License-Identifier: MIT
"""The names of records, and whether the text of a link is one."""

import re

LONGEST = 55  # with a point and four letters of a field EPICS has room for no more
_NAME = re.compile(r"[A-Za-z0-9_:;<>\[\]{}/+-]+")
WANTED = f"letters, digits and _ - : ; < > [ ] {{ }} / + are wanted, at most {LONGEST}"


def is_record_name(text: str) -> bool:
    """True if a record can have this name."""
    return len(text) <= LONGEST and _NAME.fullmatch(text) is not None


def names_a_record(text: str) -> bool:
    """True for the text of a link to a record: neither empty nor a number."""
    try:
        float(text)
    except ValueError:
        return bool(text.strip())
    return False
