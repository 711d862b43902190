# SPDX-License-Identifier: MIT
"""The comparison of two images' edges: it must find a doctored edge list, and nothing else."""

from fractions import Fraction

import pytest
import same_edges
from same_edges import Made

from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, Line
from pixstep.simulation.simctl import BOOT_S
from pixstep.simulation.simrun import Job

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
JOB = Job("mega", {0: Line((1,), PLAIN, name="a line")}, Fraction(30))


def made(text=CSV, ended="done"):
    """Return what an image made, from an edge list."""
    return Made(same_edges.read(text.encode()), ended)


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
    assert moved(later(533_333, CSV.replace("3000", "3001"))) == 0


def test_differences_are_counted_and_the_first_is_named(capsys):
    doctored = iter([CSV, CSV.replace("3000", "3001"), CSV.replace("3032", "3033")])
    outcome = same_edges.compare([JOB] * 3, lambda _: made(), lambda _: made(next(doctored)))
    assert (outcome.runs, outcome.steps, outcome.edges, outcome.differing) == (3, 9, 27, 2)
    assert not same_edges.report("mega", outcome)
    assert "first difference: run 1 (axis 0 a line, 1 pixels, 30.00 Hz): edge" in (
        capsys.readouterr().out
    )


def test_a_comparison_without_edges_proves_nothing(capsys):
    head = same_edges.HEADER + "\n"
    outcome = same_edges.compare([JOB], lambda _: made(head), lambda _: made(head))
    assert not same_edges.report("mega", outcome)
    same = same_edges.compare([JOB], lambda _: made(), lambda _: made())
    assert same_edges.report("mega", same)
    assert "0 runs differ" in capsys.readouterr().out


def test_a_file_that_is_no_edge_list_is_refused():
    with pytest.raises(UserError, match="not with its header"):
        same_edges.read(b"cycle,pin\n1,2\n")


def test_lines_are_armed_halfway_between_pixel_edges_when_all_is_uploaded():
    cycle = same_edges.arm_cycle(JOB)
    ticks_a_ms = JOB.period * JOB.pixel_hz / 1000
    pixels = (cycle - same_edges.CLOCK_START_MS * ticks_a_ms) / JOB.period
    assert abs(pixels % 1 - Fraction(1, 2)) < Fraction(1, 1000)
    assert cycle > BOOT_S * 1000 * ticks_a_ms + same_edges.UPLOAD_MS * ticks_a_ms


def test_every_axis_and_every_axis_at_once_are_run():
    wanted = same_edges.jobs("mega", 6, 1)
    assert [sorted(job.lines) for job in wanted] == [
        [0],
        *[[0, 1, 2, 3]] * 2,
        *([axis] for axis in (0, 1, 2, 3, 0, 1)),
    ]
    assert [len(job.lines) for job in same_edges.jobs("uno", 3, 1)] == [1, 1, 1, 1]


def test_an_image_makes_the_edges_that_it_makes():
    wanted = same_edges.jobs("uno", 1, 1)[1:]
    image = same_edges.natives.image("uno")
    outcome = same_edges.compare(
        wanted,
        lambda job: same_edges.run_image(job, image),
        lambda job: same_edges.run_image(job, image),
    )
    assert outcome.steps > 100
    assert outcome.differing == 0
