# SPDX-License-Identifier: MIT
"""What a command takes from its environment: a terminal of any encoding, no choice of matplotlib's.

A library leaves both alone; here the whole process belongs to the command.
"""

import codecs
import io
import os
import sys
import unicodedata

_LIKE = {
    "\u00b5": "u", "\u00b0": "deg", "\u2009": " ", "\u2212": "-", "\u2013": "-", "\u2026": "...",
    "\u25cf": "*", "\u25cb": "o", "\u00d7": "x", "\u2018": "'", "\u2019": "'",
}  # fmt: skip
_ERRORS = "pixstep"
_ASCII = "pixstep_ascii"  # click takes a stream of plain ASCII for a mistake, and writes UTF-8
_BACKEND = "MPLBACKEND"


def prepare() -> None:
    """Let every text be printed, and every picture be drawn, whatever the environment says."""
    codecs.register_error(_ERRORS, _written_otherwise)
    codecs.register(_plain_ascii)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            plain = codecs.lookup(stream.encoding).name == "ascii"
            stream.reconfigure(encoding=_ASCII if plain else None, errors=_ERRORS)
    os.environ[_BACKEND] = "agg"  # a name that matplotlib does not know would end its import


def _plain_ascii(name: str) -> codecs.CodecInfo | None:
    """Return ASCII under a name of its own."""
    if name != _ASCII:
        return None
    known = codecs.lookup("ascii")
    return codecs.CodecInfo(
        known.encode, known.decode, known.streamreader, known.streamwriter,
        known.incrementalencoder, known.incrementaldecoder, name=_ASCII,
    )  # fmt: skip


def _written_otherwise(error: UnicodeError) -> tuple[str | bytes, int]:
    """Return what stands for characters that a terminal's encoding lacks: superscript 2 is 2."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    texts = (_alike(one, error.encoding) for one in error.object[error.start : error.end])
    return b"".join(texts), error.end


def _alike(one: str, encoding: str) -> bytes:
    if "\udc80" <= one <= "\udcff":  # a byte of a file's name that is no text
        return bytes((ord(one) - 0xDC00,))
    text = _LIKE.get(one) or unicodedata.normalize("NFKD", one)
    return text.encode(encoding, "replace")
