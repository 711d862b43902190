# SPDX-License-Identifier: MIT
"""The log of a run never lies: torn at any byte, changed inside, written by two."""

import json

import pytest

import runbench
from pixstep.errors import RefusedError
from pixstep.jobs import resuming, run_log
from pixstep.jobs.run_folder import RunFolder
from pixstep.jobs.run_log import History, RunLog
from pixstep.jobs.stations import of_job
from pixstep.machine.files import MachineFile

EVENTS = [{"event": "begin", "name": "äö"}, {"event": "queued", "line": 1}, {"event": "x"}]


@pytest.fixture
def path(tmp_path):
    """Return a log of three events."""
    path = tmp_path / "log.jsonl"
    with RunLog.open(path) as log:
        for event in EVENTS:
            log.add(event)
    return path


def test_a_line_is_a_sum_a_blank_and_json(path):
    rows = path.read_bytes().splitlines()
    assert rows[1].startswith(b"%08x " % run_log.zlib.crc32(rows[1][9:]))
    assert [json.loads(row[9:]) for row in rows] == EVENTS == run_log.read(path)


def test_a_log_cut_at_every_byte_has_the_whole_lines_before_it(path):
    data = path.read_bytes()
    ends = [index + 1 for index, byte in enumerate(data) if byte == 10]
    for cut in range(len(data) + 1):
        path.write_bytes(data[:cut])
        whole = sum(end <= cut for end in ends)
        assert run_log.read(path) == EVENTS[:whole], cut
        with RunLog.open(path) as log:
            log.add({"event": "more"})
        assert run_log.read(path) == [*EVENTS[:whole], {"event": "more"}], cut


def test_a_line_that_was_changed_inside_is_named(path):
    data = path.read_bytes()
    first = data.index(b"\n")
    for at in range(first):
        path.write_bytes(data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :])
        with pytest.raises(RefusedError, match=r"log.jsonl:1: damaged"):
            run_log.read(path)
    path.write_bytes(data[:-2] + b"?\n")  # the last one is taken for torn
    assert run_log.read(path) == EVENTS[:-1]


def test_two_cannot_write_one_log(path):
    with RunLog.open(path):
        assert run_log.is_written(path)
        with pytest.raises(RefusedError, match="another process"):
            RunLog.open(path)
    assert not run_log.is_written(path)


def test_no_cut_of_a_log_makes_a_wrong_line(tmp_path, simulator):
    """The boards have printed all lines; whatever is cut, none is taken for not printed."""
    del simulator
    job = runbench.folder_with_job(tmp_path, lines=3, pixels=4)
    machine = MachineFile.load(tmp_path / "machine.toml")
    with runbench.bus() as link:
        runbench.run(tmp_path, link)
        stations = of_job(job, machine, lambda name: link)
        path = RunFolder.of(tmp_path / "a.pxrun").log_path
        data, seen = path.read_bytes(), {}
        whole = run_log.read(path)
        tag = whole[0]["boards"]["main"]["tag"]
        stations[0].board.write_setting("tag", tag)  # as while it ran
        for cut in range(len(data) + 1):
            path.write_bytes(data[:cut])
            events = run_log.read(path)
            assert events == whole[: len(events)]
            if len(events) in seen or not events:
                continue
            told = History.of(events)
            assert len(told.in_flight) <= 2
            verdict = resuming.judge(job, told, stations)
            now = told.printed | {
                one.number for one in verdict.lines if one.fate is resuming.Fate.PRINTED
            }
            seen[len(events)] = now
            left = [one for one in verdict.lines if one.fate is resuming.Fate.LEFT]
            assert not left
            if now != {1, 2, 3}:  # nothing moves before somebody has said what to do
                assert verdict.asked or verdict.to_home
        assert seen[len(whole)] == {1, 2, 3} and len(seen) == len(whole)
