# SPDX-License-Identifier: MIT
"""Good files of every format, and seeded ways to damage them."""

import random
import struct

from pixstep import formats
from reference_reader import crc32
from worked import MPOS, PRN, SAMPLE_CSV

HEADER = formats.ProfileHeader("Mon Oct 12 15:13:35 2009", "4editing1n", 1, 2, 0, "30")
LINES = ([4, 12, 8], [0, 5, -7, 32767, 0], [100])

_BYTES = b" 0123456789-+\t\r\n.,xE\x00\x1a\xb2"


def good_files() -> dict[str, bytes]:
    """Return files by name: every format, one line and many, bare and with a header."""
    many = formats.of_lines(LINES, HEADER)
    one = formats.of_lines([LINES[1]], HEADER)
    bare = formats.of_lines([LINES[1]])
    files = {path.name: path.read_bytes() for path in (PRN, MPOS, SAMPLE_CSV)}
    for name, file in (("many", many), ("one", one), ("bare", bare)):
        text = formats.encode(file)
        files[f"{name}.csv"] = text
        files[f"{name}-lf.csv"] = text.replace(b"\r\n", b"\n")
        files[f"{name}.csb"] = csb(text)
    files["lf.PRN"] = files[PRN.name].replace(b"\r\n", b"\n")
    files["six-wide.PRN"] = b"".join(line[2:] for line in files[PRN.name].splitlines(True))
    files["truncated.csb"] = csb(files[SAMPLE_CSV.name])
    return files


def csb(text: bytes) -> bytes:
    """Return the binary twin of a CSV, made here byte by byte."""
    header = text[:168] if text.startswith(b" " * 16) else b""
    rows = [int(row) for row in text[len(header) :].split()]
    body = b"CSB1" + struct.pack("<I", len(header)) + header
    return sealed(body + b"".join(struct.pack("<i", row) for row in rows))


def sealed(body: bytes) -> bytes:
    """Return a CSB's bytes with their checksum behind them."""
    return body + crc32(body).to_bytes(4, "little")


def mutate(data: bytes, chance: random.Random) -> bytes:
    """Return the data damaged once, or up to three times; never the same bytes."""
    made = data
    while made == data or not made:
        made = data
        for _ in range(chance.choice((1, 1, 1, 2, 3))):
            made = chance.choice(_CSB_WAYS if made.startswith(b"CSB1") else _WAYS)(made, chance)
    return made


def _set_byte(data: bytes, chance: random.Random) -> bytes:
    at = chance.randrange(len(data) or 1)
    return data[:at] + bytes([chance.randrange(256)]) + data[at + 1 :]


def _insert(data: bytes, chance: random.Random) -> bytes:
    at = chance.randrange(len(data) + 1)
    return data[:at] + bytes([chance.choice(_BYTES)]) + data[at:]


def _delete(data: bytes, chance: random.Random) -> bytes:
    at = chance.randrange(len(data) or 1)
    return data[:at] + data[at + chance.randint(1, 3) :]


def _flip(data: bytes, chance: random.Random) -> bytes:
    at = chance.randrange(len(data) or 1)
    return (
        data[:at]
        + bytes(byte ^ 1 << chance.randrange(8) for byte in data[at : at + 1])
        + (data[at + 1 :])
    )


def _cut(data: bytes, chance: random.Random) -> bytes:
    return data[: chance.randrange(len(data) + 1)]


def _digit(data: bytes, chance: random.Random) -> bytes:
    places = [at for at, byte in enumerate(data) if byte in b"0123456789"]
    if not places:
        return data
    at = chance.choice(places)
    return data[:at] + bytes([chance.choice(b"123456789")]) + data[at + 1 :]


def _records(change):
    """Make a way to damage a list of records out of a way to damage their bytes."""

    def way(data: bytes, chance: random.Random) -> bytes:
        records = data.splitlines(keepends=True) or [b""]
        change(records, chance.randrange(len(records)), chance)
        return b"".join(records)

    return way


def _drop(records, at, chance):
    del records[at : at + chance.randint(1, 2)]


def _double(records, at, chance):
    records.insert(chance.randrange(len(records)), records[at])


def _swap(records, at, chance):
    other = chance.randrange(len(records))
    records[at], records[other] = records[other], records[at]


def _keep_first(records, at, chance):
    del records[at + 1 :]


def _other_end(records, at, chance):
    text = records[at].rstrip(b"\r\n")
    records[at] = text + chance.choice((b"\n", b"\r", b"\r\n", b"\n\r", b"\r\r\n", b""))


def _all_lf(records, at, chance):
    records[:] = [record.replace(b"\r\n", b"\n") for record in records]


def _no_final_newline(records, at, chance):
    records[-1] = records[-1].rstrip(b"\r\n")


def _new_value(records, at, chance):
    width = chance.choice((len(records[at].rstrip(b"\r\n")), 6, 8))
    value = chance.choice((0, 1, 2, 3, -5, 7, 100, 99_999, 999_999, chance.randrange(10**6)))
    records[at] = b"%*d\r\n" % (width, value)


def _shift(records, at, chance):
    text, end = records[at].rstrip(b"\r\n"), records[at][len(records[at].rstrip(b"\r\n")) :]
    blank = text.strip(b" ")
    choices = (blank.ljust(len(text)), blank, b" " + text, text + b" ", blank.zfill(len(text)))
    records[at] = chance.choice(choices) + end


def _reseal(change):
    """Make a way that damages a CSB and gives it a right checksum again."""
    return lambda data, chance: sealed(change(data[:-4], chance))


def _row(data: bytes, chance: random.Random) -> bytes:
    """Replace, insert or remove a whole row of a CSB."""
    start = 8 + int.from_bytes(data[4:8], "little") if len(data) >= 8 else 8
    at = start + 4 * chance.randrange(max(1, (len(data) - start) // 4))
    value = chance.choice((0, 1, 2, -1, 5, 3, 1_000_000, -(2**31)))
    row = chance.choice((b"", struct.pack("<i", value)))
    return data[:at] + row + data[at + chance.choice((0, 4)) :]


def _last_rows(data: bytes, chance: random.Random) -> bytes:
    return data[: -4 * chance.randint(1, 2)]


_WAYS = (
    _set_byte, _insert, _delete, _flip, _cut, _digit, _digit, _digit,
    *map(_records, (
        _drop, _double, _swap, _keep_first, _other_end, _all_lf, _no_final_newline, _new_value,
        _new_value, _shift,
    )),
)  # fmt: skip
_CSB_WAYS = (
    _set_byte, _insert, _delete, _flip, _cut,
    *map(_reseal, (_set_byte, _cut, _row, _row, _row, _last_rows, _last_rows, _digit, _insert)),
)  # fmt: skip
