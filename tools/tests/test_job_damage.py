# SPDX-License-Identifier: MIT
"""Files of a job, a run, a simulation that are not as they were: one line names them, no more."""

import json
import shutil
from pathlib import Path

import pytest

import jobbench
import reportbench
import runbench
from pixstep.jobs import judging, run_log
from pixstep.jobs.job import Job
from pixstep.jobs.run_folder import RunFolder
from pixstep.jobs.simulated.folder import SimFolder


def empty(path):
    path.write_bytes(b"")


def cut(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def no_text(path):
    path.write_bytes(b"\xff\xfe\x00\x80" * 20)


def folder_instead(path):
    path.unlink()
    path.mkdir()


DAMAGES = (empty, cut, no_text, folder_instead)


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """Return a folder with a machine, a job and a run that has ended, with records."""
    folder = tmp_path_factory.mktemp("kept")
    job = runbench.folder_with_job(folder)
    made = reportbench.MadeUp(folder / "a.pxrun", job)
    made.print(1, 2)
    made.record((1, 2), lambda *_: (0, 0))
    return folder


@pytest.fixture
def folder(kept, tmp_path, monkeypatch):
    """Return a copy of the same, as the current folder."""
    shutil.copytree(kept, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def refused(invoke, *words):
    """Return the one line by which a command is refused."""
    done = invoke(*words, status=None)
    assert done.exit_code in (2, 3), done.output
    assert done.stderr.count("\n") == 1 and done.stderr.startswith("pixstep: ")
    return done.stderr


@pytest.fixture
def asked(invoked, folder):
    """Return a function that runs a command in the folder, with any status."""
    from click.testing import CliRunner

    def run(*words, status=None):
        done = CliRunner().invoke(invoked, [str(word) for word in words])
        assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
        assert status is None or done.exit_code == status, done.output
        return done

    return run


READERS = (
    ("job", "status", "a.pxrun"), ("job", "pause", "a.pxrun"), ("watch", "a.pxrun", "--once"),
    ("job", "report", "a.pxrun"), ("job", "resume", "a.pxrun", "--port", "nowhere"),
)  # fmt: skip


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("words", READERS, ids=" ".join)
def test_a_run_whose_job_is_damaged(folder, asked, damage, words):
    damage(folder / "a.pxrun/job.pxjob")
    assert "a.pxrun/job.pxjob: " in refused(asked, *words)


@pytest.mark.parametrize("damage", [empty, no_text, folder_instead])
@pytest.mark.parametrize("words", READERS, ids=" ".join)
def test_a_run_whose_log_is_damaged(folder, asked, damage, words):
    damage(folder / "a.pxrun/log.jsonl")
    assert "log.jsonl" in refused(asked, *words)


@pytest.mark.parametrize("words", [one for one in READERS if "pause" not in one], ids=" ".join)
def test_a_log_with_events_of_another_pixstep(folder, asked, words):
    path = folder / "a.pxrun/log.jsonl"
    path.write_bytes(path.read_bytes() + run_log.encoded({"event": "chain", "line": 3}))
    assert "log.jsonl: has events that this pixstep does not know" in refused(asked, *words)


@pytest.mark.parametrize("damage", DAMAGES)
def test_records_that_are_damaged(folder, asked, damage):
    damage(folder / "a.pxrun/parts/line-000002.parquet")
    said = refused(asked, "job", "report", "a.pxrun")
    assert "parts/line-000002.parquet: no records of a run: " in said


def test_a_folder_that_is_called_pause_asks_for_none(folder, asked):
    (folder / "a.pxrun/pause").mkdir()
    assert not RunFolder(folder / "a.pxrun").pause_asked
    with RunFolder(folder / "a.pxrun").log():  # as if somebody ran it
        assert "a.pxrun/pause: Is a directory" in refused(asked, "job", "pause", "a.pxrun")


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"\xff\xfe\x00\x80", "machine.toml: not UTF-8 at byte 0"),
        (b"[clock]\npixel = \n[x]", "machine.toml:2:"),
        (jobbench.MACHINE.replace("axis = 1", "axis = 9").encode(), ": motors.M40.axis = 9: "),
        (b"", "machine.toml:1: clock: is missing"),
    ],
)
def test_a_machine_file_that_is_none(folder, asked, data, said):
    (folder / "machine.toml").write_bytes(data)
    nowhere = ("--port", "nowhere")
    for words in (
        ("job", "check", "a.pxjob"), ("job", "resume", "a.pxrun", *nowhere),
        ("job", "run", "a.pxjob", *nowhere, "--folder", "b.pxrun"),
    ):  # fmt: skip
        found = refused(asked, *words)
        assert said in found and "validation" not in found and "Input should" not in found
    (folder / "machine.toml").unlink()
    (folder / "machine.toml").mkdir()
    assert "no machine file: --machine FILE, " in refused(asked, "job", "check", "a.pxjob")


def test_red_is_said_before_anybody_homes(folder, asked):
    text = jobbench.MACHINE.replace('"30 Hz"', '"31 Hz"')
    (folder / "machine.toml").write_text(text)
    said = refused(asked, "job", "resume", "a.pxrun", "--port", "nowhere")
    assert "a.pxrun/job.pxjob: red: machine.toml: clock.pixel: the job has 30 Hz" in said


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (empty, "simulation.json is damaged"), (cut, "simulation.json is damaged"),
        (no_text, "simulation.json is damaged"),
        (folder_instead, "simulation.json: Is a directory"),
        (Path.unlink, "simulation.json is not there"),
        (lambda path: path.write_text("[]"), "simulation.json tells of none"),
        (lambda path: path.write_text("[" * 100_000), "simulation.json is damaged"),
    ],
)  # fmt: skip
def test_a_simulation_that_is_damaged(folder, asked, damage, said):
    place = folder / "print.pxsim"
    SimFolder(place).begin({"job": "a.pxjob"})
    damage(place / "simulation.json")
    before = sorted(place.rglob("*"))
    found = refused(asked, "job", "simulate", "a.pxjob", "--out", "print.pxsim")
    assert f"print.pxsim: is the folder of no simulation: {said}: " in found
    assert sorted(place.rglob("*")) == before


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (("text",), "mine: has text and no run"),
        (("job.pxjob",), "mine: has job.pxjob and no run"),
        (("job.pxjob", "text"), "mine: has job.pxjob and no run"),
        (("a/b",), "mine: has a and no run"),
    ],
)
def test_a_run_goes_into_no_folder_of_something_else(folder, asked, names, said):
    for name in names:
        path = folder / "mine" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("mine")
    found = refused(asked, "job", "run", "a.pxjob", "--folder", "mine", "--port", "nowhere")
    assert said in found and "--folder names a new one" in found
    kept = [path for path in (folder / "mine").rglob("*") if path.is_file()]
    assert len(kept) == len(names) and {path.read_text() for path in kept} == {"mine"}


def test_a_begin_that_was_cut_short_is_begun_again(folder):
    job = Job.read(folder / "a.pxjob")
    (folder / "b.pxrun").mkdir()
    shutil.copy(folder / "a.pxjob", folder / "b.pxrun/job.pxjob")
    assert RunFolder.begin(folder / "b.pxrun", job).job_path.is_file()


def test_a_pixel_that_is_measured_twice(folder, asked):
    rows = ["line,motor,pixel,measured_steps", "1,M39,1,5", "1,M39,2,5", "2,M39,1,5", "1,M39,1,6"]
    (folder / "m.csv").write_text("\n".join(rows) + "\n")
    said = refused(asked, "job", "report", "a.pxrun", "--measured", "m.csv")
    assert "m.csv: row 4: line 1, motor M39, pixel 1: row 1 has measured it already" in said


@pytest.mark.parametrize(
    ("kind", "text", "said"),
    [
        ("useq", '{"stage_positions": [{"x": "a", "y": 0}]}',
         "s.json: stage_positions.x = 'a': expected a valid number"),
        ("useq", '{"stage_positions": 7}', "s.json: stage_positions = 7: not what useq has there"),
        ("useq", '{"stage_positions": [{"x": 0', "s.json:1:28: no JSON: EOF while parsing"),
        ("useq", "", "s.json:1:0: no JSON: EOF while parsing a value"),
        ("useq", "[]", "s.json: no useq specification: fields with values are wanted"),
        ("useq", b"\xff\xfe\x00", "s.json:1:1: no JSON: "),
        ("scanspec", '{"type": "Nix"}', "s.json: type = 'Nix': one of Product, Zip, "),
        ("scanspec", '{"type": "Linspace"', "s.json:1:20: no JSON: "),
        ("scanspec", "[]", "s.json: no scanspec specification: fields with values are wanted"),
        ("scanspec", '{"type": "Linspace", "axis": "X", "start": 0, "stop": 1, "num": -5}',
         "s.json: Linspace.num = -5: expected greater than or equal to 1"),
        ("scanspec", b"\xff\xfe", "s.json: not UTF-8 at byte 0"),
        ("scanspec", "", "s.json:1:1: no JSON: "),
    ],
)  # fmt: skip
def test_a_specification_is_refused_in_our_words(folder, asked, kind, text, said):
    (folder / "s.json").write_bytes(text if isinstance(text, bytes) else text.encode())
    found = refused(asked, "job", "make", f"--{kind}", "s.json", "-o", "b.pxjob")
    assert said in found
    for word in ("pydantic", "validation", "Input", "class", "codec", "MDASequence"):
        assert word not in found


def test_the_axes_of_a_specification_are_motors(folder, asked):
    spec = {"outer": {"axis": "M41", "start": 0, "stop": 2, "num": 3, "type": "Linspace"},
            "inner": {"axis": "M7", "start": 0, "stop": 5, "num": 6, "type": "Linspace"},
            "gap": True, "type": "Product"}  # fmt: skip
    (folder / "s.json").write_text(json.dumps(spec))
    words = ("job", "make", "--scanspec", "s.json", "-o", "b.pxjob")
    said = refused(asked, *words)
    assert "s.json: axis M7: no motor is called so: --axis-of MOTOR=M7 names one of M39, " in said
    said = refused(asked, *words, "--axis-of", "M39=zz")
    assert "--axis-of M39=zz: s.json has axes M41 and M7" in said


def test_a_table_that_a_motor_cannot_follow_is_named(folder, asked):
    (folder / "t.csv").write_text("line,M40\r\n1,0\r\n1,9000\r\n1,9000\r\n")
    said = refused(asked, "job", "make", "--table", "t.csv", "-o", "b.pxjob")
    assert "pixstep: t.csv: line 1 of motor M40: " in said and "machine.toml" not in said


def test_dense_pixels_of_several_boards_are_told(tmp_path):
    def told(text, **more):
        job = runbench.folder_with_job(tmp_path, text=text, **more)
        return [*judging.apart(job, job.machine.tables)]

    fast = runbench.TWO.replace('"30 Hz"', '"300 Hz"').replace("divider = 1", "divider = 10")
    (first, *_) = told(fast)
    assert "of motor M39: " in first and "more than 2 ticks apart if the clock jitters" in first
    assert told(runbench.TWO) == []
    assert told(fast.replace('sync = "lock"', 'sync = "start"')) == []
