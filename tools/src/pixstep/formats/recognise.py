# SPDX-License-Identifier: MIT
"""Which format a file has, by its content: never by its name alone."""

from collections import Counter
from dataclasses import dataclass
from itertools import islice

from pixstep.formats.csvtext import has_header
from pixstep.formats.findings import shown
from pixstep.formats.header import HEADER_WIDTH
from pixstep.formats.motion import CSB_KIND, CSV_KIND
from pixstep.formats.prn import KIND as PRN_KIND
from pixstep.formats.records import split_records

KINDS = (PRN_KIND, CSV_KIND, CSB_KIND)
_LOOKED_AT = 64
_BY_WIDTH = {6: CSV_KIND, 8: PRN_KIND}


@dataclass(frozen=True)
class Recognised:
    """A format and the reason; `kind` is None for a file that has none of them."""

    kind: str | None
    why: str


def recognise(data: bytes) -> Recognised:
    """Say which format bytes have, whether or not they are right in it."""
    if data.startswith(b"CSB"):
        return Recognised(CSB_KIND, f"begins with {shown(data[:4])}")
    first = next(split_records(data), b"")
    if has_header(data):
        what = f"{HEADER_WIDTH} columns wide" if len(first) == HEADER_WIDTH else "text"
        return Recognised(CSV_KIND, f"its first line is {what}, as a header is")
    looked_at = list(islice(split_records(data), _LOOKED_AT))
    widths = Counter(len(text) for text in looked_at if text.strip(b" +-0123456789") == b"")
    votes = {width: widths[width] for width in _BY_WIDTH if widths[width]}
    if not votes:
        return Recognised(
            None,
            f"{shown(first)} is {len(first)} columns wide: neither a PRN (8 columns of digits) "
            "nor a CSV (6, or a header of 40) nor a CSB",
        )
    width = max(votes, key=lambda width: (votes[width], width == len(first)))
    why = f"{votes[width]} of the first {len(looked_at)} records are numbers in {width} columns"
    return Recognised(_BY_WIDTH[width], why)
