# SPDX-License-Identifier: MIT
"""Short ways to write one row of a table of fields."""

from functools import partial

from pixstep.motor_record.field import Field, FieldType

setting = partial(Field, type=FieldType.DOUBLE)
"""A number that clients write."""
reading = partial(Field, type=FieldType.DOUBLE, writable=False)
"""A number that only the record writes."""
count = partial(Field, type=FieldType.LONG)
counted = partial(Field, type=FieldType.LONG, writable=False)
button = partial(Field, type=FieldType.SHORT)
flag = partial(Field, type=FieldType.SHORT, writable=False)
choice = partial(Field, type=FieldType.MENU)
text = partial(Field, type=FieldType.STRING)
link = partial(Field, type=FieldType.LINK, default="")
