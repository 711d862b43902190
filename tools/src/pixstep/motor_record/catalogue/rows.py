# SPDX-License-Identifier: MIT
"""Short ways to write one row of a table of fields."""

from functools import partial

from pixstep.motor_record.field import FieldType, RecordField

setting = partial(RecordField, type=FieldType.DOUBLE)
"""A number that clients write."""
reading = partial(RecordField, type=FieldType.DOUBLE, writable=False)
"""A number that only the record writes."""
count = partial(RecordField, type=FieldType.LONG)
counted = partial(RecordField, type=FieldType.LONG, writable=False)
button = partial(RecordField, type=FieldType.SHORT)
flag = partial(RecordField, type=FieldType.SHORT, writable=False)
choice = partial(RecordField, type=FieldType.MENU)
text = partial(RecordField, type=FieldType.STRING)
link = partial(RecordField, type=FieldType.LINK, default="")
