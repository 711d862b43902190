# SPDX-License-Identifier: MIT
"""The generated part of docs/FILES.md: meanings, messages, a CSB byte by byte, commands.

Every message and listing is what the readers and commands really say.
"""

import contextlib
import shlex
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from click.testing import CliRunner

from pixstep import formats, natives
from pixstep.cli.command import Group
from pixstep.cli.main import file as file_group
from pixstep.formats import describe
from pixstep.formats.files import NAMES, check_name, examine_bytes
from pixstep.formats.findings import ERROR, LENIENT, STRICT, Tolerance
from pixstep_dev.markdown import table

_SAMPLE = "tools/data/AccProf-sample.csv"
_PRN = "tools/data/AccProfM39-30Hz-1.PRN"
_MPOS = "tools/data/mpos-worked-example.csv"

_COMMANDS = (
    f"file info {_SAMPLE}",
    f"file check {_SAMPLE}",
    f"file check --lenient {_SAMPLE}",
    f"file info {_PRN}",
    f"file check --decode smooth {_PRN}",
    f"file convert {_MPOS} line.csb",
    "file info line.csb",
    f"file convert {_PRN} plain.csv",
    f"file convert {_PRN} plain.csv --decode plain --header ramp --pixel-hz 30 "
    "--date 'Mon Oct 12 15:13:35 2009'",
    "file info plain.csv",
)

_PRN_QUIRKS = (
    ("LF", b"       8\n      16\n"),
    ("no newline at the end", b"       8\r\n      16"),
    ("a CR alone", b"       8\r      16\r\n"),
    ("6 wide", b"     8\r\n    16\r\n"),
    ("one record 6 wide", b"       8\r\n      16\r\n    24\r\n"),
    ("one record too wide", b"       8\r\n       16\r\n"),
    ("left-aligned", b"       8\r\n16      \r\n"),
    ("leading zeros", b"       8\r\n00000016\r\n"),
    ("a tab", b"       8\r\n\t     16\r\n"),
    ("a sign", b"       8\r\n     +16\r\n"),
    ("an empty record", b"       8\r\n\r\n"),
    ("more than 8 digits", b"       8\r\n100000000\r\n"),
    ("not a number", b"       8\r\n    16.0\r\n"),
    ("not ASCII", b"       8\r\n      \xb26\r\n"),
    ("the end mark of DOS", b"       8\r\n\x1a"),
)


def files() -> str:
    """Return the generated part as Markdown."""
    parts = ["### What a value means\n", _meanings()]
    parts += ["\n### What is said of a PRN\n", _messages(_PRN_QUIRKS, "x.PRN")]
    parts += ["\n### What is said of a CSV and a CSB\n", _messages(tuple(_csv_quirks()), "x.csv")]
    parts += ["\n### The smallest CSB, of the values 4 and -7\n", _fence(_bytes_of_a_csb())]
    parts += ["\n### Commands and what they print\n", _fence(_session())]
    return "\n".join(parts) + "\n"


def _meanings() -> str:
    """Return the table of meanings, and of the header's fields."""
    rows = [(NAMES[kind], *both) for kind, both in describe.VALUES.items()]
    fields = list(describe.FIELDS.items())
    return "\n".join([
        table(("file", "smooth motor (M39)", "plain motor (all others)"), rows),
        "",
        table(("header field", "meaning"), fields),
    ])  # fmt: skip


def _csv_quirks() -> Iterator[tuple[str, bytes]]:
    """Yield quirks of CSV and CSB as what they are and the file."""
    sample = natives.source(_SAMPLE).read_bytes()
    good = sample.replace(b"   100\r", b"     3\r").replace(b"HAPs:  10", b"HAPs:   2")
    yield "LF", b"     8\n    16\n"
    yield "8 wide", b"       8\r\n      16\r\n"
    yield "one record too wide", b"     8\r\n     16\r\n"
    yield "a plus sign", b"     8\r\n    +9\r\n"
    yield "truncated count", good.replace(b"     3\r", b"   100\r")
    yield "truncated lines", good.replace(b"Lines:    1", b"Lines:    2")
    yield "surplus rows", good.replace(b"     3\r", b"     2\r")
    yield "line number", good.replace(b"     1\r", b"     7\r")
    yield "no prefix", good[:168] + b"    10\r\n    10\r\n    10\r\n"
    yield "HAPs above the values", good.replace(b"HAPs:   2", b"HAPs:  10")
    yield "prefix without a header", good[168:]
    yield "header too wide", good.replace(b"2009\r", b"2009 \r")
    yield "label", good.replace(b"Lines:", b"LINES:")
    yield "no ctime", good.replace(b"Mon Oct", b"12. Oct")
    yield "day of the week", good.replace(b"Mon Oct", b"Tue Oct")
    yield "frequency 0", good.replace(b"30\r", b" 0\r")
    yield "CSB under this name", _csb_sample()
    yield "CSB, a byte changed", _csb_sample()[:-8] + b"\0" + _csb_sample()[-7:]
    yield "CSB, another version", b"CSB2" + _csb_sample()[4:]


def _messages(quirks: tuple[tuple[str, bytes], ...], name: str) -> str:
    """Return the table of what a strict and a lenient reader say."""
    rows = []
    for what, data in quirks:
        file = "x.csb" if what.startswith("CSB,") else name
        strict, lenient = _said(data, file, STRICT), _said(data, file, LENIENT)
        rows.append((what, strict, "the same" if lenient == strict else lenient))
    return table(("what", "strict", "lenient"), rows)


def _said(data: bytes, name: str, rules: Tolerance) -> str:
    """Return the findings of a reader, with their places."""
    examined = examine_bytes(Path(name), data, rules)
    check_name(examined)
    texts = []
    for item in examined.findings.in_order():
        severity = "" if item.severity == ERROR else f"{item.severity}: "
        texts.append(f"{severity}`{item.line}:{item.column}: {item.message}`")
    return "<br>".join(texts) or "fine"


def _csb_sample() -> bytes:
    return formats.encode(replace(formats.of_lines([[4, -7]]), kind="csb"))


def _bytes_of_a_csb() -> str:
    """Return a CSB in hexadecimal, a part a line."""
    data = _csb_sample()
    parts = (
        (0, 4, "magic, CSB1"),
        (4, 8, "length of the header text: none"),
        (8, 12, "4"),
        (12, 16, "-7"),
        (16, 20, "CRC-32 of bytes 0 to 15"),
    )
    return "\n".join(
        f"{start:>4}  {data[start:end].hex(' ')}  {what}" for start, end, what in parts
    )


def _session() -> str:
    """Run the commands in an empty folder with `tools` in it; return them and what they print."""
    parts = []
    pixstep = Group(commands=[file_group])
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        Path("tools").symlink_to(natives.root() / "tools", target_is_directory=True)
        for command in _COMMANDS:
            done = CliRunner().invoke(pixstep, shlex.split(command))
            parts.append(
                f"$ tools/pixstep {command}\n{done.output}[exit status {done.exit_code}]\n"
            )
    return "\n".join(parts)


def _fence(text: str) -> str:
    return f"```\n{text.rstrip()}\n```"
