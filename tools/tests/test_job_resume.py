# SPDX-License-Identifier: MIT
"""After a run that was broken off: nothing is guessed, nothing moves before it is decided."""

import os
import signal
from types import SimpleNamespace
from unittest import mock

import pytest

import runbench
from pixstep import ops
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.errors import BoardError
from pixstep.errors import RefusedError, UserError
from pixstep.jobs import account, resuming, runner
from pixstep.jobs.run_folder import RunFolder
from pixstep.jobs.run_log import Base
from pixstep.operations.bus import StoppedError


@pytest.fixture
def folder(tmp_path, simulator):
    """Return a folder with a machine and a job of four short lines."""
    del simulator
    runbench.folder_with_job(tmp_path)
    return tmp_path


def steps_of(folder, *lines):
    """Return the edges that the scanning motor makes in lines."""
    job = runbench.Job.read(folder / "a.pxjob")
    return sum(job.line(line)["M39"].total_steps for line in lines)


def events(folder, kind):
    """Return the events of a kind."""
    return [one for one in RunFolder.of(folder / "a.pxrun").events() if one["event"] == kind]


def test_ctrl_c_pauses_and_the_second_one_stops(folder):
    with runbench.bus() as link:
        once = runbench.Hook(link.simulator, 72, lambda: os.kill(os.getpid(), signal.SIGINT))
        twice = runbench.Hook(link.simulator, 76, lambda: os.kill(os.getpid(), signal.SIGINT))
        with pytest.raises(StoppedError, match=r"stopped by Ctrl-C.*board 1 axis 0 at position"):
            runbench.run(folder, link)
        assert once.count > 72 and twice.count >= 76
        assert set(ops.job_status(folder / "a.pxrun")["state"].split()) == {"broken"}
        (stopped,) = events(folder, "stopped")
        assert stopped["line"] == 1 and stopped["motors"][0]["motor"] == "M39"
        made = link.simulator.count(0, 0)
        found = runbench.resume(folder, link)
        assert found.status == 3 and found["state"] == "undecided"
        (line,) = [one for one in found["in_flight"] if one["fate"] == "broken"]
        assert line["line"] == 1 and "broken at pixel" in line["text"]
        assert "redo 1 or skip 1" in found.page() and "nothing has moved" in found.page()
        assert link.simulator.count(0, 0) == made
        with pytest.raises(UserError, match="line 3 is neither broken nor unknown: 1 are"):
            runbench.resume(folder, link, redo=(3,))
        found = runbench.resume(folder, link, redo=(1,))  # positions after a hard stop
        assert found.status == 3 and "positions do not hold: M39" in found.page()
        done = runbench.resume(folder, link, redo=(1,), homed=True)
        assert (done["state"], done["printed"]) == ("finished", 4)
        moved = events(folder, "moved")[0]["motors"]["M39"]
        assert moved[1] == 0 and link.simulator.steps(0, 0) == 0
        printed = steps_of(folder, 1, 2, 3, 4)
        assert link.simulator.count(0, 0) > made + printed  # and the way back


def test_a_board_that_was_reset_leaves_two_lines_unknown(folder):
    with runbench.bus() as link:
        runbench.Hook(link.simulator, 70, lambda: link.simulator.reset(0))
        with pytest.raises(BoardError, match="board 1: it was reset"):
            runbench.run(folder, link)
        (lost,) = events(folder, "lost")
        assert lost["board"] == "main"
        found = runbench.resume(folder, link)
        unknown = [one["line"] for one in found["in_flight"] if one["fate"] == "unknown"]
        assert found.status == 3 and 1 <= len(unknown) <= 2
        assert not found["boards"][0]["trusted"] and "reset" in found["boards"][0]["text"]
        done = runbench.resume(folder, link, skip=tuple(unknown), homed=True)
        assert done["state"] == "finished" and done["skipped"] == unknown
        assert done["printed"] == 4 - len(unknown)


@pytest.mark.parametrize("state", ["done", "loaded", "empty", "fault"])
def test_counters_that_have_gone_back_are_no_place(folder, state):
    job = runbench.Job.read(folder / "a.pxjob")
    base = Base(unit=1, axis=0, lines_done=7, next_block=9, position_steps=0)
    now = {"lines_done": 0, "next_block": 0, "position_steps": 0, "pixel": 0}
    now["axis_state"] = next(code for code in range(8) if regs.axis_state(code) == state)
    axis = account.JobAxis(next(iter(job.motors)), base, now)
    assert axis.has_gone_back
    assert account.place_of(job, 1, axis) is None


def test_a_job_of_wet_material_begins_again(tmp_path, simulator):
    del simulator
    job = runbench.folder_with_job(tmp_path)
    about = job.header.model_copy(update={"resumable": False})
    runbench.replaced(job, about).write(tmp_path / "a.pxjob")
    with runbench.bus() as link:
        runbench.Hook(link.simulator, 60, RunFolder(tmp_path / "a.pxrun").ask_pause)
        assert runbench.run(tmp_path, link)["state"] == "paused"
        with pytest.raises(RefusedError, match="not resumable"):
            runbench.resume(tmp_path, link)


def test_a_machine_that_is_red_prints_nothing(folder):
    text = (folder / "machine.toml").read_text()
    (folder / "machine.toml").write_text(text.replace('"30 Hz"', '"31 Hz"'))
    with runbench.bus() as link:
        with pytest.raises(RefusedError, match="red: "):
            runbench.run(folder, link)
        assert link.simulator.count(0, 0) == 0
    assert not (folder / "a.pxrun").exists()


def test_amber_wants_a_yes(folder):
    text = (folder / "machine.toml").read_text()
    (folder / "machine.toml").write_text(text.replace('"250 steps"', '"100 steps"'))
    with runbench.bus() as link:
        with pytest.raises(RefusedError, match=r"amber: .*backlash"):
            runbench.run(folder, link, accept_amber=False)
        assert link.simulator.count(0, 0) == 0
        done = runbench.run(folder, link)  # the job's 250 steps are sent
        assert done["state"] == "finished"
        assert link.simulator.count(0, 0) == steps_of(folder, 1, 2, 3, 4)
    (begun,) = events(folder, "begin")
    assert begun["comparison"] == "amber" and begun["accepted_by"]


def test_motors_that_are_elsewhere_are_named_and_brought(folder):
    with runbench.bus() as link:
        ops.board_move(folder / "move.csv", steps=-40, axis=0, link=link, pixel_hz=30)
        with pytest.raises(
            RefusedError, match=r"motor M39 .board main. is at -40, the line begins"
        ):
            runbench.run(folder, link)
        made = link.simulator.count(0, 0)
        done = runbench.run(folder, link, to_start=True)
        assert done["state"] == "finished" and link.simulator.count(0, 0) > made
        assert events(folder, "moved")[0]["motors"]["M39"] == [-40, 0]


def test_what_was_decided_stays_decided(folder):
    with runbench.bus() as link:
        runbench.Hook(link.simulator, 72, lambda: os.kill(os.getpid(), signal.SIGINT))
        runbench.Hook(link.simulator, 76, lambda: os.kill(os.getpid(), signal.SIGINT))
        with pytest.raises(StoppedError):
            runbench.run(folder, link)
        with pytest.raises(UserError, match=r"motor M39 has no profiles.home, or no home_is_limit"):
            runbench.resume(folder, link, skip=(1,), home=True)
        assert not events(folder, "skip")  # nothing was decided by what is not possible
        runbench.Hook(link.simulator, 1, RunFolder(folder / "a.pxrun").ask_pause)
        done = runbench.resume(folder, link, skip=(1,), homed=True)
        assert done["state"] == "paused" and done["skipped"] == [1]
        done = runbench.resume(folder, link, skip=(1,))  # again: it is decided
        assert (done["state"], done["printed"], done["skipped"]) == ("finished", 3, [1])


def test_a_board_that_was_reset_and_has_taken_a_line_since_is_named(folder):
    """The next line goes out between the reset and the next look."""
    with runbench.bus() as link:
        job = runbench.Job.read(folder / "a.pxjob")
        real = runner.Chain._send_until

        def send(chain, until_s):
            if chain.made == 1 and chain._sender.begun == 2:
                link.simulator.reset(0)
                link.simulator.boot()
            real(chain, until_s)

        with (
            mock.patch.object(runner.Chain, "_send_until", send),
            pytest.raises(BoardError, match="board 1: it was reset"),
        ):
            runbench.run(folder, link)
        assert link.board().axis(0)["next_block"] > 0 and job.lines == 4
        found = runbench.resume(folder, link)
        fates = [(one["line"], one["fate"]) for one in found["in_flight"]]
        assert fates == [(2, "unknown"), (3, "unknown")]


@pytest.mark.parametrize(
    ("places", "fate", "text"),
    [
        ([(8, 0), (8, 0)], "printed", "printed"),
        ([(7, 0), (7, 0)], "not printed", "not printed"),
        ([(7, 12), (7, 9)], "broken", "broken at pixel 9 of 40"),
        ([(8, 0), (7, 9)], "broken", "broken at pixel 9 of 40"),
        ([(8, 0), (7, 0)], "broken", "broken: made by board A alone"),
        ([(8, 0), None], "unknown", "unknown: board B does not know it any more"),
        ([(7, 0), None], "unknown", "unknown: board B does not know it any more"),
        ([None, None], "unknown", "unknown: board A, B does not know it any more"),
    ],
)
def test_what_became_of_a_line(places, fate, text):
    job = SimpleNamespace(pixels=40)
    found = [
        resuming.BoardAtResume(
            SimpleNamespace(name=name), account.LinePlace(*place) if place else None, True, ""
        )
        for name, place in zip("AB", places, strict=True)
    ]
    line = resuming._line(job, 7, found)
    assert (line.fate.value, line.text) == (fate, text)


def test_ctrl_c_stops_motors_on_their_way_to_the_start(folder):
    with runbench.bus() as link:
        ops.board_move(folder / "move.csv", steps=-4000, axis=0, link=link, pixel_hz=30)
        made = link.simulator.count(0, 0)

        def interrupt():
            if link.simulator.count(0, 0) > made + 500:
                os.kill(os.getpid(), signal.SIGINT)

        runbench.Hook(link.simulator, None, interrupt)
        with pytest.raises(StoppedError, match="stopped by Ctrl-C: board 1 axis 0 at position"):
            runbench.run(folder, link, to_start=True)
        assert 500 < link.simulator.count(0, 0) - made < 4000
    assert not events(folder, "chain")


def test_what_is_of_the_run_itself_is_neither_guessed_nor_replaced(folder, invoke, monkeypatch):
    with runbench.bus() as link:
        runbench.run(folder, link)
    run = folder / "a.pxrun"
    kept = (run / "log.jsonl").read_bytes()
    done = invoke("job", "report", run, "-o", run / "log.jsonl", "--force", status=2)
    assert "is of the run itself" in done.stderr and (run / "log.jsonl").read_bytes() == kept
    (run / "log.jsonl").write_text("")
    for words in (("job", "resume"), ("job", "status"), ("job", "report")):
        assert "tells of no run that has begun" in invoke(*words, run, status=3).stderr
    (run / "log.jsonl").write_bytes(kept)
    monkeypatch.chdir(folder)
    machine = (folder / "machine.toml").read_bytes()
    words = ("--image-size", "9x2", "--scan", "M39=400", "-o", "machine.toml", "--force")
    assert "is the input" in invoke("job", "make", *words, status=2).stderr
    assert (folder / "machine.toml").read_bytes() == machine
    invoke("job", "make", *words[:-3], "-o", "b.pxjob")
    (run / "job.pxjob").write_bytes((folder / "b.pxjob").read_bytes())
    assert "is not the job" in invoke("job", "resume", run, status=3).stderr


def stop_at_once(folder, link, before=72):
    """Print the job of a folder, and stop in its first line by Ctrl-C, twice."""
    runbench.Hook(link.simulator, before, lambda: os.kill(os.getpid(), signal.SIGINT))
    runbench.Hook(link.simulator, before + 4, lambda: os.kill(os.getpid(), signal.SIGINT))
    with pytest.raises(StoppedError):
        runbench.run(folder, link)


def test_a_resume_that_is_refused_decides_nothing(folder):
    with runbench.bus() as link:
        stop_at_once(folder, link)
        text = (folder / "machine.toml").read_text()
        (folder / "machine.toml").write_text(text.replace('"250 steps"', '"100 steps"'))
        with pytest.raises(RefusedError, match="amber: "):
            runbench.resume(folder, link, skip=(1,), homed=True, accept_amber=False)
        assert not events(folder, "skip") and not events(folder, "redo")
        runbench.Hook(link.simulator, 1, RunFolder(folder / "a.pxrun").ask_pause)
        done = runbench.resume(folder, link, skip=(1,), homed=True)
        assert (done["state"], done["skipped"]) == ("paused", [1])
        with pytest.raises(UserError, match="line 1: it was skipped at an earlier resume"):
            runbench.resume(folder, link, redo=(1,))
        assert len(events(folder, "resume")) == 1


def test_another_decision_about_a_line_that_is_not_printed_yet_is_taken(folder):
    with runbench.bus() as link:
        stop_at_once(folder, link)
        runbench.Hook(link.simulator, 1, RunFolder(folder / "a.pxrun").ask_pause)
        done = runbench.resume(folder, link, redo=(1,), homed=True)
        assert (done["state"], done["printed"]) == ("paused", 0)
        RunFolder(folder / "a.pxrun").ask_pause()
        assert runbench.resume(folder, link, redo=(1,))["printed"] == 0  # the same is no mistake
        done = runbench.resume(folder, link, skip=(1,))
        assert (done["state"], done["printed"], done["skipped"]) == ("finished", 3, [1])
        assert done["repeated"] == []


def test_a_line_that_was_begun_and_printed_again_makes_the_report_amber(folder):
    with runbench.bus() as link:
        stop_at_once(folder, link)
        done = runbench.resume(folder, link, redo=(1,), homed=True)
    (one,) = done["repeated"]
    assert one["line"] == 1 and one["was"].startswith("broken at pixel ")
    assert f"repeated 1 ({one['was']})" in done.page()
    made = ops.job_report(folder / "a.pxrun", output=folder / "a.html")
    assert made["verdict"] == f"Finished: 4 of 4 lines printed; repeated: 1 ({one['was']})"
    assert (made["colour"], made.status) == ("amber", 1)
    assert '"fates":[4,1,1,1]' in (folder / "a.html").read_text()


def test_what_boards_have_said_of_a_line_outlives_homing(folder):
    with runbench.bus() as link:
        stop_at_once(folder, link)
        found = runbench.resume(folder, link)
        said = {one["line"]: one["text"] for one in found["in_flight"]}
        assert "broken at pixel" in said[1] and said[2] == "not printed"
        ops.board_move(folder / "move.csv", steps=40, axis=0, link=link, pixel_hz=30)
        again = runbench.resume(folder, link)
        assert {one["line"]: one["text"] for one in again["in_flight"]} == said
        assert not again["boards"][0]["trusted"]
        (found,) = events(folder, "found")
        assert [one["fate"] for one in found["lines"]] == ["broken", "not printed"]
        assert f"line 1: {said[1]}" in ops.job_status(folder / "a.pxrun").page()


def paused(folder, link):
    """Print the job of a folder until it pauses."""
    runbench.Hook(link.simulator, 60, RunFolder(folder / "a.pxrun").ask_pause)
    assert runbench.run(folder, link)["state"] == "paused"
    return link.simulator.count(0, 0)


def test_a_pressed_emergency_stop_and_its_fault_stop_a_resume(folder):
    (estop,) = [one for one in boards.load("mega").pins if one.signal == "ESTOP"]
    port, bit = estop.port, estop.bit
    with runbench.bus() as link:
        made = paused(folder, link)
        link.simulator.pin(0, port, bit, 0)
        link.simulator.wait_s(0.1)
        found = runbench.resume(folder, link, homed=True)
        assert found.status == 3 and "the emergency stop is pressed: release it" in found.page()
        link.simulator.pin(0, port, bit, 1)
        link.simulator.wait_s(0.1)
        found = runbench.resume(folder, link, homed=True)
        assert found.status == 3 and "fault estop" in found.page()
        assert "`pixstep board clear`" in found.page() and link.simulator.count(0, 0) == made
        ops.board_clear(link=link)
        assert runbench.resume(folder, link, homed=True)["state"] == "finished"


def test_a_resume_without_a_pixel_clock_moves_nothing(folder):
    with runbench.bus() as link:
        paused(folder, link)
        ops.board_move(folder / "move.csv", steps=40, axis=0, link=link, pixel_hz=30)
        made = link.simulator.count(0, 0)
        link.simulator.clock("off")
        link.simulator.wait_s(1)
        found = runbench.resume(folder, link, homed=True)
        assert found.status == 3 and "board main: no pixel clock comes" in found.page()
        assert link.simulator.count(0, 0) == made and not events(folder, "resume")
        link.simulator.clock("on")
        assert runbench.resume(folder, link, homed=True)["state"] == "finished"
