# SPDX-License-Identifier: MIT
"""The comparison of two images' edges: it must find a doctored edge list, and nothing else."""

from dataclasses import replace
from fractions import Fraction

import edge_trials
import pytest
import same_edges
from edge_trials import Trial
from same_edges import Made

from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.runs import Seek
from pixstep.simulation.job import LOCK, LineExperiment
from pixstep.simulation.pixel_clock import ClockFlaws
from pixstep.simulation.simulator import BOOT_S

CSV = """\
cycle,board,axis,signal,level
900,0,0,ENABLE,1
1000,0,0,DIR,1
2000,0,0,STEP,1
2000,0,1,STEP,1
2032,0,0,STEP,0
2032,0,1,STEP,0
2500,0,1,DIR,1
3000,0,1,STEP,1
3032,0,1,STEP,0
"""
JOB = LineExperiment("mega", {0: Line((1,), PLAIN, name="a line")}, Fraction(30))
LINE = Trial(JOB)


def made(text=CSV, ended="done", event=None):
    """Return what an image made, from an edge list."""
    return Made(same_edges.read(text.encode()), ended, event)


def difference(text, ended="done"):
    """Return the difference of a doctored edge list."""
    return same_edges.difference(made(), made(text, ended))


@pytest.mark.parametrize(
    ("right", "wrong", "found"),
    [
        ("3000,0,1,STEP,1", "3001,0,1,STEP,1", "3000,0,1,STEP,1 before, 3001,0,1,STEP,1 now"),
        ("3032,0,1,STEP,0\n", "", "3032,0,1,STEP,0 before, after 1 steps,0,1,DIR,1 now"),
        ("2500,0,1,DIR,1", "2500,0,1,DIR,0", "0,1,DIR,1 before, after 1 steps,0,1,DIR,0 now"),
        ("2500,0,1,DIR,1\n", "", "9 edges before, 8 now"),
        ("1000,0,0,DIR,1", "1000,0,0,PERMIT,1", "DIR,1 before, after 0 steps,0,0,ENABLE,1 now"),
    ],
)
def test_a_doctored_edge_is_found(right, wrong, found):
    assert CSV.count(right) == 1
    assert found in difference(CSV.replace(right, wrong))


def test_a_direction_edge_behind_another_step_is_found():
    moved = CSV.replace("2500,0,1,DIR,1\n", "").replace(
        "2000,0,1,STEP,1\n", "1990,0,1,DIR,1\n2000,0,1,STEP,1\n"
    )
    assert "after 1 steps,0,1,DIR,1 before, after 0 steps,0,1,DIR,1 now" in difference(moved)


def test_another_end_is_found():
    assert difference(CSV, "fault decoder_late") == (
        "ended as 'done' before, as 'fault decoder_late' now"
    )


def test_what_software_or_the_order_of_a_cycle_may_move_is_no_difference():
    moved = CSV.replace("900,0,0,ENABLE", "950,0,0,ENABLE").replace("2500,0,1", "2504,0,1")
    swapped = moved.replace(
        "2000,0,0,STEP,1\n2000,0,1,STEP,1\n", "2000,0,1,STEP,1\n2000,0,0,STEP,1\n"
    )
    assert swapped != moved
    assert difference(swapped) == ""
    assert same_edges.shift(made(), made(swapped)) == 4


def later(cycles, text=CSV):
    """Return an edge list with every edge so much later."""
    head, *rows = text.splitlines()
    moved = [f"{int(row.split(',')[0]) + cycles},{row.partition(',')[2]}" for row in rows]
    return "\n".join([head, *moved, ""])


def test_a_run_at_another_pixel_edge_is_told_apart_from_a_difference():
    period = JOB.period  # 533,333 and a third

    def moved(text):
        return same_edges.moved_pixels(made(), made(text), period)

    assert [moved(later(1_066_667)), moved(later(533_333))] == [2, 1]
    assert moved(later(533_300)) == 0
    assert moved(later(533_333).replace(",0,1,STEP,0", ",0,1,STEP,1", 1)) == 0
    assert moved(later(533_333, CSV.replace("3032", "3033"))) == 1
    assert moved(later(533_333, CSV.replace("3000", "3001"))) == 0


def test_differences_are_counted_and_the_first_is_named(capsys):
    doctored = iter([CSV, CSV.replace("3000", "3001"), CSV.replace("2000,0,0", "2001,0,0")])
    outcome = same_edges.compare([LINE] * 3, lambda _: made(), lambda _: made(next(doctored)))
    assert (outcome.runs, outcome.steps, outcome.edges, outcome.differing) == (3, 9, 27, 2)
    assert not same_edges.report("mega", outcome)
    assert "first difference: run 1 (line: axis 0 a line, 1 pixels, 30.00 Hz): edge" in (
        capsys.readouterr().out
    )


def test_a_comparison_without_edges_proves_nothing(capsys):
    head = same_edges.HEADER + "\n"
    outcome = same_edges.compare([LINE], lambda _: made(head), lambda _: made(head))
    assert not same_edges.report("mega", outcome)
    same = same_edges.compare([LINE], lambda _: made(), lambda _: made())
    assert same_edges.report("mega", same)
    assert "0 runs differ" in capsys.readouterr().out


def test_a_file_that_is_no_edge_list_is_refused():
    with pytest.raises(UserError, match="not with its header"):
        same_edges.read(b"cycle,pin\n1,2\n")


def test_lines_are_armed_halfway_between_pixel_edges_when_all_is_uploaded():
    cycle = same_edges.arm_cycle(LINE)
    ticks_a_ms = JOB.period * JOB.pixel_hz / 1000
    pixels = (cycle - same_edges.CLOCK_START_MS * ticks_a_ms) / JOB.period
    assert abs(pixels % 1 - Fraction(1, 2)) < Fraction(1, 1000)
    assert cycle > BOOT_S * 1000 * ticks_a_ms + same_edges.UPLOAD_MS * ticks_a_ms


def test_every_axis_and_every_axis_at_once_are_run():
    wanted = same_edges.wanted_trials("mega", 6, 0, 1)
    assert [sorted(trial.job.lines) for trial in wanted] == [
        [0],
        *[[0, 1, 2, 3]] * 2,
        *([axis] for axis in (0, 1, 2, 3, 0, 1)),
    ]
    alone = same_edges.wanted_trials("uno", 3, 0, 1)
    assert [len(trial.job.lines) for trial in alone] == [1, 1, 1, 1]


def excuse(trial, old, new):
    """Return what kind of a difference it is that a faster image may make, if it is one."""
    assert same_edges.difference(old, new)
    return same_edges.excuse(trial, old, new)


def test_a_locked_run_may_be_ticks_apart_and_no_more():
    trial = Trial(replace(JOB, sync=LOCK), "lock")
    near = made(CSV.replace("3000", "3002"))
    assert excuse(trial, made(), near) == same_edges.NEAR
    assert same_edges.near_ticks(made(), near) == 2
    for wrong in (
        made(CSV.replace("3000", "3003")),
        made(CSV.replace("3000", "3001"), "done fault"),
        made(CSV.replace("3000", "3001").replace("2500,0,1,DIR,1\n", "")),
        made(CSV.replace("3000,0,1,STEP,1\n3032,0,1,STEP,0\n", "")),
    ):
        assert excuse(trial, made(), wrong) == ""
    assert excuse(LINE, made(), made(CSV.replace("3000", "3001"))) == ""
    poor = replace(trial, job=replace(trial.job, flaws=ClockFlaws(jitter_us=2)))  # 32 ticks
    assert excuse(poor, made(), made(CSV.replace("3000", "3034"))) == same_edges.NEAR
    assert excuse(poor, made(), made(CSV.replace("3000", "3035").replace("3032", "3067"))) == ""


def test_a_locked_run_at_another_edge_may_be_ticks_apart_too():
    trial = Trial(replace(JOB, sync=LOCK), "lock")
    near = made(later(533_000).replace("535000,0,1", "535002,0,1"))
    off = made(later(533_000).replace("535000,0,1", "535003,0,1"))
    half = made(later(266_000))
    assert [excuse(trial, made(), new) for new in (near, off, half)] == [same_edges.MOVED, "", ""]
    assert excuse(LINE, made(), near) == ""


def test_a_pulse_may_end_elsewhere():
    assert excuse(LINE, made(), made(CSV.replace("3032", "3099"))) == same_edges.FALLS
    assert excuse(LINE, made(), made(CSV.replace("3032", "3099").replace("3000", "3001"))) == ""
    assert excuse(LINE, made(), made(CSV.replace("3032,0,1,STEP,0\n", ""))) == ""
    assert excuse(LINE, made(), made(CSV.replace("3032", "3099"), "fault")) == ""


def test_a_stopped_run_is_the_same_up_to_the_stop():
    trial = Trial(JOB, "stop", stop_s=0.1)
    shorter = CSV.replace("3000,0,1,STEP,1\n3032,0,1,STEP,0\n", "")
    assert excuse(trial, made(event=2600), made(shorter, event=2600)) == same_edges.ANSWERED
    late = CSV + "40000,0,1,STEP,1\n40032,0,1,STEP,0\n"
    wrong = "empty, steps miscounted"
    for old, new in (
        (made(event=2600), made(late, event=2600)),
        (made(event=3100), made(shorter, event=3100)),
        (made(event=2600), made(shorter, "empty", 2600)),
        (made(CSV, wrong, 2600), made(shorter, wrong, 2600)),
    ):
        assert excuse(trial, old, new) == ""


def test_a_seek_may_begin_anywhere():
    trial = Trial(JOB, "seek", seek=Seek((4, 8), 10))
    assert excuse(trial, made(event=2600), made(later(4096), event=6696)) == same_edges.MOVED
    moved = later(4096, CSV.replace("2000,0,1,STEP,1", "2001,0,1,STEP,1"))
    assert excuse(trial, made(event=2600), made(moved, event=6696)) == ""
    assert excuse(LINE, made(), made(later(4096))) == ""


def test_a_seek_may_be_as_the_old_image_makes_it_at_another_phase():
    trial = Trial(JOB, "seek", seek=Seek((4, 8), 10))
    longer = CSV + "40000,0,1,STEP,1\n40032,0,1,STEP,0\n"

    def at(phases):
        return lambda trial: made(longer if trial.phase in phases else CSV, event=2600)

    chance = at(same_edges.RACE_PHASES[6:7])
    outcome = same_edges.compare([trial], chance, lambda _: made(longer, event=2600))
    assert (outcome.differing, outcome.excused) == (0, {same_edges.RACED: 1})
    outcome = same_edges.compare([trial], at(()), lambda _: made(longer, event=2600))
    assert (outcome.differing, outcome.excused) == (1, {})
    outcome = same_edges.compare([LINE], chance, lambda _: made(longer, event=2600))
    assert outcome.differing == 1


def test_an_overloaded_line_may_come_further_or_less_far():
    late, shorter = "fault decoder_late", CSV.replace("3000,0,1,STEP,1\n3032,0,1,STEP,0\n", "")
    for old, new, found in (
        (made(shorter, late), made(), same_edges.FURTHER),
        (made(shorter, late), made(CSV, "fault underrun"), same_edges.FURTHER),
        (made(shorter, late), made(later(533_333), late), same_edges.FURTHER),
        (made(shorter, f"trouble: {late} on axis 0"), made(), same_edges.FURTHER),
        (made(CSV, late), made(shorter, late), same_edges.LESS_FAR),
        (made(), made(shorter, late), same_edges.LESS_FAR),
        (made(shorter, late), made(CSV, "fault estop"), ""),
        (made(shorter), made(), ""),
        (made(shorter, "fault estop"), made(), ""),
        (made(shorter, late), made(CSV.replace("2000,0,1", "2001,0,1")), ""),
        (made(shorter, late), made(CSV, "done, steps miscounted"), ""),
        (made(shorter, late), made(later(533_300)), ""),
    ):
        assert excuse(LINE, old, new) == found
    locked = Trial(replace(JOB, sync=LOCK), "lock")
    old, near = made(shorter, late), made(later(533_000).replace("535000,0,1", "535002,0,1"))
    assert excuse(locked, old, near) == same_edges.FURTHER
    off = made(later(533_000).replace("535000,0,1", "535003,0,1"))
    assert [excuse(locked, old, off), excuse(LINE, old, near)] == ["", ""]


def test_another_phase_is_tried_where_two_images_begin_on_different_edges():
    tried = []

    def run_new(trial):
        tried.append(trial.phase)
        return made(later(533_333) if trial.phase == Fraction(1, 2) else CSV)

    outcome = same_edges.compare([LINE], lambda _: made(), run_new)
    assert tried == [Fraction(1, 2), Fraction(1, 4)]
    assert (outcome.differing, outcome.excused) == (0, {})
    always = same_edges.compare([LINE], lambda _: made(), lambda _: made(later(533_333)))
    assert (always.differing, always.excused) == (0, {same_edges.MOVED: 1})


def knobs_of(trial):
    """Return what is set of each plant of a trial."""
    return [dict(one.split("=") for one in text.split(",")) for text in trial.job.plants.values()]


def test_the_trials_are_those_that_are_promised():
    wanted = list(edge_trials.trials("mega", 12, 1))
    assert [(trial.kind, trial.job) for trial in wanted] == [
        (trial.kind, trial.job) for trial in edge_trials.trials("mega", 12, 1)
    ]
    by_kind = {
        kind: [trial for trial in wanted if trial.kind == kind]
        for kind in {trial.kind for trial in wanted}
    }
    assert sorted(by_kind) == ["divider", "fast clock", "lock", "seek", "stop", "stream"]
    assert {len(of) for of in by_kind.values()} == {12}
    fast = [trial.job.pixel_hz for kind in ("fast clock", "divider") for trial in by_kind[kind]]
    assert min(fast) == 500 and max(fast) == 5000
    locks = [trial.job for trial in by_kind["lock"]]
    assert all(job.locked and job.pixel_ppm for job in locks)
    for name in ("jitter_us", "drop", "double"):
        assert len({getattr(job.flaws, name) for job in locks}) > 1, name
    assert max(job.divider for job in locks) > 1 and {len(job.lines) for job in locks} == {1, 4}
    assert all(trial.records for trial in by_kind["stream"])
    assert {trial.by_contact for trial in by_kind["stop"]} == {True, False}
    assert all(trial.seek and trial.job.plants for trial in by_kind["seek"])
    for knobs in (text for trial in edge_trials.trials("m1284", 40, 1) for text in knobs_of(trial)):
        assert 0 < int(knobs["bounce_ticks"]) >= int(knobs["bounce"])


def test_an_image_makes_the_edges_that_it_makes_in_every_kind():
    wanted = list(edge_trials.trials("uno", 1, 3))
    image = same_edges.natives.image("uno")
    ends = {}

    def run(trial):
        ends[trial.kind] = same_edges.run_image(trial, image)
        return ends[trial.kind]

    outcome = same_edges.compare(wanted, run, run)
    assert (outcome.runs, outcome.refused, outcome.differing) == (6, 0, 0)
    assert outcome.excused == {}
    for kind, found in ends.items():
        assert found.ended.startswith("empty" if kind == "stop" else "done"), (kind, found.ended)
        assert found.steps > 10, kind
        assert (found.event is not None) == (kind in ("stop", "seek"))


def test_an_image_makes_the_edges_that_it_makes():
    wanted = same_edges.wanted_trials("uno", 1, 0, 1)[1:]
    image = same_edges.natives.image("uno")
    outcome = same_edges.compare(
        wanted,
        lambda job: same_edges.run_image(job, image),
        lambda job: same_edges.run_image(job, image),
    )
    assert outcome.steps > 100
    assert outcome.differing == 0
