# SPDX-License-Identifier: MIT
"""10,000 damaged files (fewer in the quick check): read rightly or refused in one line.

A second reader says what is right.
"""

import random
import re
import time
from collections import Counter
from pathlib import Path

import pytest
from click.testing import CliRunner

import reference_reader
from effort import cases
from mutants import good_files, mutate
from pixstep import formats
from pixstep.cli.main import main
from pixstep.errors import UserError
from pixstep.formats import motion
from pixstep.formats.files import examine_bytes
from pixstep.formats.findings import LENIENT, STRICT, Findings

COUNT = cases(2_000, 10_000)
SEED = 1
MODES = ({}, {"lenient": True}, {"raw": True})
LONGEST_MESSAGE = 500
MOST_SECONDS = 1.0


def mutants(count=COUNT, seed=SEED):
    """Yield a name and the damaged bytes, the good files in turn."""
    chance = random.Random(seed)
    files = good_files()
    names = sorted(files)
    for number in range(count):
        name = names[number % len(names)]
        yield name, mutate(files[name], chance)


def content(file):
    """Return what was read in the form of the second reader."""
    if isinstance(file, formats.PrnFile):
        return reference_reader.Content("prn", (), ((len(file.values), file.values),))
    header = tuple(row.encode() for row in file.header.rows) if file.header else ()
    lines = tuple((block.declared, block.values) for block in file.blocks)
    return reference_reader.Content(file.kind, header, lines)


def assert_one_line(text, path, data):
    """The message names file, line and column, is one line of ASCII, and the place is there."""
    found = re.match(re.escape(str(path)) + r":(\d+):(\d+): \S", text)
    assert found, text
    assert "\n" not in text and text.isascii() and text.isprintable()
    assert len(text) < LONGEST_MESSAGE + len(str(path))
    line, column = int(found[1]), int(found[2])
    assert 1 <= line <= data.count(b"\n") + 1
    if not data.startswith(b"CSB"):
        row = data.split(b"\n")[line - 1]
        assert 1 <= column <= max(len(row), 8) + 1, text


def outcome_of(path, data, mode):
    """Read damaged bytes one way; return `read` or `refused`, checked against the reference."""
    expected = reference_reader.read(data, **mode)
    started = time.process_time()
    try:
        rules = LENIENT if mode.get("lenient") else STRICT
        read = examine_bytes(path, data, rules, raw=mode.get("raw", False)).required()
    except UserError as error:
        assert time.process_time() - started < MOST_SECONDS
        assert_one_line(str(error), path, data)
        assert expected is None, f"{error}, but the second reader reads {expected}: {data!r}"
        return "refused"
    assert time.process_time() - started < MOST_SECONDS
    assert content(read) == expected, data
    assert formats.encode(read) == data
    return "read"


def test_thousands_of_damaged_files():
    counts, by_format = Counter(), Counter()
    path = Path("damaged")
    for name, data in mutants():
        for mode in MODES:
            outcome = outcome_of(path, data, mode)
            counts[outcome, *mode] += 1
            by_format[outcome, name.rpartition(".")[2]] += 1
    print(dict(counts), dict(by_format))
    for mode in MODES:
        assert counts["read", *mode] + counts["refused", *mode] == COUNT
        assert counts["read", *mode] > COUNT * 0.10
        assert counts["refused", *mode] > COUNT * 0.30
    assert counts["read", "lenient"] > counts[("read",)] + COUNT * 0.05
    for kind in ("PRN", "csv", "csb"):
        assert min(by_format["read", kind], by_format["refused", kind]) > COUNT * 0.05


def test_reference_reads_the_good_files(tmp_path):
    """The second reader is no judge unless it reads what is right, alike."""
    files = good_files()
    for name, data in files.items():
        path = tmp_path / name
        path.write_bytes(data)
        read = formats.read_any(path, lenient=True)
        assert reference_reader.read(data, lenient=True) == content(read) is not None
        assert formats.encode(read) == data


CSB_SAMPLES = ["many.csb", "one.csb", "bare.csb", "truncated.csb"]


@pytest.mark.parametrize("name", CSB_SAMPLES)
def test_checksum_catches_every_change_of_a_byte(name):
    data = good_files()[name]
    refused = 0
    for at in range(len(data)):
        for value in range(256):
            if value != data[at]:
                findings = Findings()
                made = motion.parse_csb(data[:at] + bytes([value]) + data[at + 1 :], findings)
                refused += made is None and findings.found[0].name in ("crc", "magic")
    assert refused == len(data) * 255


@pytest.mark.parametrize("name", CSB_SAMPLES)
def test_checksum_catches_every_truncation(name):
    data = good_files()[name]
    for length in range(len(data)):
        findings = Findings()
        assert motion.parse_csb(data[:length], findings) is None
        assert findings.refused


def test_commands_refuse_in_one_line(tmp_path, monkeypatch):
    """A sample through the commands: status 3, one line that names the place, no other exception.

    `info` tolerates what a lenient or a raw reading takes.
    """
    monkeypatch.chdir(tmp_path)
    tried = Counter()
    for _, data in mutants(600, seed=2):
        (tmp_path / "damaged").write_bytes(data)
        strict = reference_reader.read(data)
        readable = strict or any(
            reference_reader.read(data, lenient=True, raw=raw) for raw in (0, 1)
        )
        expected = {"convert damaged out.csv --force --decode plain --drop-header": strict is None}
        expected["info damaged"] = not readable
        expected["info damaged --json"] = not readable
        for command, refused in expected.items():
            done = CliRunner().invoke(main, ["file", *command.split()])
            assert done.exception is None or isinstance(done.exception, SystemExit), data
            tried[command, done.exit_code] += 1
            if refused:
                assert done.exit_code == 3 and done.stdout == ""
                assert re.fullmatch(r"pixstep: damaged:\d+:\d+: [ -~]+\n", done.stderr), done.stderr
            elif command.startswith("info"):
                assert done.exit_code == 0, done.output
    assert tried["info damaged", 3] > 100 and tried["info damaged", 0] > 100


def test_check_lists_every_finding(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    statuses = Counter()
    for _, data in mutants(400, seed=3):
        (tmp_path / "damaged").write_bytes(data)
        done = CliRunner().invoke(main, ["file", "check", "damaged"])
        assert done.exception is None or isinstance(done.exception, SystemExit), data
        *findings, last = done.stdout.splitlines()
        assert all(
            re.match(r"damaged:\d+:\d+: (error|warning|note): \S", line) for line in findings
        )
        refused = reference_reader.read(data) is None
        assert (done.exit_code == 3) == refused == any(": error: " in line for line in findings)
        assert last.startswith("damaged: refused") == refused
        statuses[done.exit_code] += 1
    assert min(statuses[0], statuses[3]) > 40
