# SPDX-License-Identifier: MIT
"""Drawings show the line: arrays against the decode rule, drawn data against the arrays."""

import json
from fractions import Fraction

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.transforms import Bbox

from effort import cases
from pixstep import formats, plotting
from pixstep.cli.main import main
from pixstep.errors import UserError
from pixstep.lines import exact, line_check
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.units import ACCELERATION, JERK, SPEED
from pixstep.profiles import figure, kinematics
from worked import ACCELERATING, MPOS, PRN, worked_line

TURNING = Line((10, 20, 20, 10, 0, -10, -10), PLAIN)


@pytest.fixture
def draw():
    """Return a function that builds a figure and returns its axes by label."""

    def build(line, **more):
        made = figure.build(kinematics.LineDrawing(line, "title", **more))
        return {axes.get_label(): axes for axes in made.axes}

    return build


def drawn(axes, gid):
    """Data of the lines (or steps) of one name."""
    found = [item for item in axes.get_children() if item.get_gid() == gid]
    assert len(found) == 1, gid
    return found[0].get_data()


@pytest.mark.parametrize("backlash", [0, 1, 250, 1000])
def test_arrays_of_the_worked_example(backlash):
    line = worked_line(backlash)
    motion = kinematics.of(line)
    assert kinematics.figures(line) == kinematics.LineMagnitudes(
        60, line.total_steps, 1000, 128, 104
    )
    assert motion.positions[-1] == line.total_steps == sum(line.counts) + backlash
    times, steps = motion.curve()
    on_edges = {round(t, 9): s for t, s in zip(times, steps, strict=True)}
    truth = exact.expected_positions(line)
    for pixel in range(line.shifted_pixels + 1, 61):
        assert on_edges[pixel] == truth[pixel - 1]


def test_positions_inside_the_shifted_part_are_the_table_of_exact_values():
    motion = kinematics.of(worked_line(250))
    times, steps = motion.curve(points=4)  # the clock edges lie a quarter into shifted pixels
    at = dict(zip(np.round(times, 9).tolist(), steps.tolist(), strict=True))
    assert [at[k] for k in (2, 3, 4, 5, 6)] == [6.25, 20.25, 42.25, 72.1875, 108.6875]
    assert (at[15], at[16], at[17]) == (3697.25, 4668, 5668)


def test_jerk_counts_from_rest_and_to_rest():
    motion = kinematics.of(Line((5, 10, 10, 5)))
    assert motion.accelerations.tolist() == [10, 0, 0, -10]
    assert motion.jerks.tolist() == [10, -10, 0, -10, 10]


def test_peak_jerk_is_where_the_line_check_begins_to_warn():
    line = worked_line(0)
    peak = kinematics.figures(line).peak_jerk
    assert line_check.check(line, line_check.Limits(jerk_warning=peak)) == []
    assert line_check.check(line, line_check.Limits(jerk_warning=peak - 1)) != []


def test_plain_lines_jump_at_the_edges():
    motion = kinematics.of(TURNING)
    assert motion.speed_changes.tolist() == [10, 10, 0, -10, -10, -10, 0, 10]
    assert motion.jerks.tolist() == [10, 0, -10, -10, 0, 0, 10, 10]
    assert motion.positions.tolist() == [0, 10, 30, 50, 60, 60, 50, 40]
    assert kinematics.of(TURNING, going_on=True).speed_changes[-1] == 0


def test_phases_of_the_worked_example():
    found = [(p.kind, p.begin, p.end) for p in figure.phases(worked_line(250))]
    assert found == [
        (figure.REST, 0, 0.75), (figure.UP, 0.75, 15.75), (figure.TAKE_UP, 15.75, 16),
        (figure.CONSTANT, 16, 44), (figure.DOWN, 44, 59), (figure.REST, 59, 60),
    ]  # fmt: skip
    (swing,) = figure.phases(Line((10,) * 4))
    assert swing.text == "oscillates between 0 and 20 steps/px"
    assert [p.text for p in figure.phases(TURNING)][-1] == "constant \N{MINUS SIGN}10"


@pytest.mark.parametrize("line", [worked_line(250), Line((10,) * 4), Line((5, 10, 10, 5))])
def test_what_is_drawn_is_the_smooth_line(draw, line):
    panels = draw(line)
    motion = kinematics.of(line)
    times, speeds = drawn(panels["speed"], "speed")
    assert np.array_equal(times, motion.corners[0]) and np.array_equal(speeds, motion.corners[1])
    if not line.backlash:
        assert drawn(panels["speed"], "boundary speeds")[1].tolist() == list(line.speeds)
    values, edges, _ = drawn(panels["acceleration"], "acceleration")
    assert np.array_equal(values, motion.accelerations)
    assert np.array_equal(edges, motion.edges_px)
    jumps = motion.jerks != 0
    times, jerks = drawn(panels["jerk"], "jerk kept")
    assert np.array_equal(times, motion.edges_px[jumps])
    assert np.array_equal(jerks, motion.jerks[jumps])
    times, steps = drawn(panels["position"], "position")
    assert np.array_equal((times, steps), motion.curve()) and steps[-1] == line.total_steps


def test_what_is_drawn_is_the_plain_line(draw):
    panels = draw(TURNING)
    speeds = drawn(panels["speed"], "speed")[1]
    assert speeds[::2].tolist() == speeds[1::2].tolist() == list(TURNING.counts)
    assert drawn(panels["acceleration"], "acceleration kept")[1].tolist() == [
        10, 10, -10, -10, -10, 10,
    ]  # fmt: skip
    assert drawn(panels["position"], "position")[1][-1] == 40


def test_limits_and_what_exceeds_them(draw):
    panels = draw(worked_line(0), limits={SPEED: 1200, ACCELERATION: 128, JERK: 80})
    beyond = drawn(panels["jerk"], "jerk beyond")
    assert beyond[1].tolist() == [-104, -104] and beyond[0].tolist() == [15, 45]
    bounds = [
        line.get_ydata()[0] for line in panels["jerk"].lines if line.get_gid() == "limit jerk"
    ]
    assert bounds == [80, -80]
    assert drawn(panels["speed"], "limit speed")[1] == [1200, 1200]


def test_a_far_limit_is_said_and_does_not_flatten_the_curve(draw):
    line = worked_line(0)
    limits = {SPEED: 100 * line.line_speed, ACCELERATION: 10**6, JERK: 80}
    panels = draw(line, limits=limits)
    for name, limit in (("speed", 100_000), ("acceleration", 10**6)):
        said = panels[name].get_title(loc="right")
        assert said == f"limit {plotting.number(limit)}, out of the picture"
        assert f"limit {name}" not in {mark.get_gid() for mark in panels[name].lines}
        assert panels[name].get_ylim()[1] < 1.3 * panels[name].dataLim.ymax
    assert not panels["jerk"].get_title(loc="right")
    legend = panels["speed"].figure.legends[0]
    assert "limit" in [text.get_text() for text in legend.get_texts()]  # that of the jerk
    far = draw(line, limits={SPEED: limits[SPEED]})["speed"].figure
    assert "limit" not in [text.get_text() for one in far.legends for text in one.get_texts()]


def test_marks_of_backlash_image_and_oscillation(draw):
    line = worked_line(250)
    panels = draw(line, image_pixel=20)
    assert drawn(panels["jerk"], "image")[0] == [19, 19]
    legend = panels["speed"].figure.legends[0]
    texts = [text.get_text() for text in legend.get_texts()]
    assert texts == [
        "250 steps of backlash taken up, px 15.75 to 16", "image starts with pixel 20",
    ]  # fmt: skip
    legend = draw(Line((10,) * 4))["speed"].figure.legends[0]
    assert "pixels 1 to 4 oscillate: 10 entered at 0" in legend.get_texts()[0].get_text()


def test_right_hand_scale_is_per_second(draw):
    panels = draw(worked_line(0), pixel_hz=Fraction(30))
    scales = panels["jerk"].child_axes
    assert [scale.get_ylabel() for scale in scales] == ["steps/s³"]
    low, high = panels["jerk"].get_ylim()
    panels["jerk"].figure.canvas.draw()
    assert scales[0].get_ylim() == pytest.approx((27_000 * low, 27_000 * high))


def shown_ticks(axes):
    """Tick labels of the axes whose places are in view."""
    for axis in (axes.xaxis, axes.yaxis):
        low, high = sorted(axis.get_view_interval())
        for tick in axis.get_major_ticks() if axes.axison else ():
            if low <= tick.get_loc() <= high:
                yield from (tick.label1, tick.label2)


def texts_of(one):
    """All texts that a figure shows with their bounding boxes in pixels, a pixel less around."""
    found = list(one.texts)
    for legend in one.legends:
        found += legend.get_texts()
    for axes in [child for panel in one.axes for child in (panel, *panel.child_axes)]:
        found += [*axes.texts, axes.xaxis.label, axes.yaxis.label, axes.title, axes._left_title]
        found += shown_ticks(axes)
    boxes = []
    for text in found:
        if text.get_visible() and text.get_text().strip():
            box = text.get_window_extent()
            if text.get_text().endswith("\n"):  # the subtitle stands in its second line
                box = Bbox([[box.x0, (box.y0 + box.y1) / 2], [box.x1, box.y1]])
            boxes.append((text.get_text(), box.padded(-1)))
    return boxes


@pytest.mark.parametrize(
    ("line", "image"),
    [
        (worked_line(250), 20),
        (TURNING, None),
        (Line(tuple([501, 1000, 1000, 501, 0] * 40)), None),
        *cases(
            [],
            [
                (Line((10,) * 4), None),
                (Line((5, 10, 10, 5)), None),
                (worked_line(250, pixels=5000), 17),
            ],
        ),
    ],
)
def test_no_texts_overlap(draw, line, image):
    limits = {SPEED: 1200, ACCELERATION: 128, JERK: 110}
    one = draw(line, pixel_hz=Fraction(30), limits=limits, image_pixel=image)["speed"].figure
    one.canvas.draw()
    boxes = texts_of(one)
    clashes = {
        (a, b) for k, (a, one_box) in enumerate(boxes) for b, other in boxes[k + 1 :]
        if one_box.overlaps(other)
    }  # fmt: skip
    assert clashes == set()
    assert len(boxes) > 25
    inside = one.bbox.padded(1)
    assert [text for text, box in boxes if not inside.contains(box.x0, box.y0)
            or not inside.contains(box.x1, box.y1)] == []  # fmt: skip


def run(*words, status=0):
    done = CliRunner().invoke(main, [str(word) for word in words])
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    assert done.exit_code == status, done.output
    return done.output


def test_profile_show(tmp_path):
    output = run("profile", "show", PRN, "-o", tmp_path / "a.png")
    assert "peak speed" in output and "38400" in output and "115200" in output
    assert (tmp_path / "a.png").read_bytes()[:4] == b"\x89PNG"
    report = json.loads(run("profile", "show", PRN, "--speed", 1000, "--json"))
    assert (report["steps"], report["pixels"]) == (sum(ACCELERATING), 15)
    assert report["peak_jerk_steps_per_s3"] == 104 * 27_000
    plain = json.loads(run("profile", "show", PRN, "--decode", "plain", "--json"))
    assert (plain["pixels"], plain["peak_speed_steps_per_px"]) == (17, 1280)


# PNG is drawn below as well.
@pytest.mark.parametrize("suffix", cases(["svg", "pdf"], ["svg", "pdf", "png"]))
def test_line_show(tmp_path, suffix):
    path = tmp_path / f"a.{suffix}"
    report = json.loads(
        run("line", "show", MPOS, "--decode", "smooth", "--lead-in", 2, "-o", path, "--json")
    )
    assert report["image_pixel"] == 19 and report["drawing"] == str(path)
    assert path.stat().st_size > 10_000


def test_line_show_takes_lead_in_and_frequency_from_the_header(tmp_path):
    header = formats.ProfileHeader("Mon Oct 12 15:13:35 2009", "mine", 1, 0, 3, "25")
    formats.write_csv(tmp_path / "a.csv", list(worked_line(250).counts), header)
    report = json.loads(run("line", "show", tmp_path / "a.csv", "--decode", "smooth",
                            "--backlash", 250, "--json"))  # fmt: skip
    assert report["image_pixel"] == 20 and report["length_s"] == 60 / 25
    assert report["steps"] == worked_line(250).total_steps


def test_a_line_at_rest_and_one_that_reverses_can_be_drawn(tmp_path):
    for name, counts in (("rest", [0, 0]), ("wrong", [10, 2, 30])):
        formats.write_csv(tmp_path / f"{name}.csv", counts)
        run("line", "show", tmp_path / f"{name}.csv", "--decode", "smooth",
            "-o", tmp_path / f"{name}.png")  # fmt: skip
        assert (tmp_path / f"{name}.png").exists()


def test_misuse(tmp_path):
    text = run("line", "show", MPOS, "--decode", "smooth", "-o", tmp_path / "a.txt", status=2)
    assert "a drawing ends with .png, .svg, .pdf" in text
    text = run("line", "show", MPOS, "--decode", "smooth", "--backlash", 1001, status=2)
    assert "backlash 1001, speed 1000" in text
    text = run("line", "show", MPOS, "--decode", "plain", "--backlash", 1, status=2)
    assert "needs a smooth line" in text
    text = run("profile", "show", MPOS, "--speed", 10, status=2)
    assert "--speed is for a PRN" in text
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(UserError, match="a drawing ends with"):
        figure.save(kinematics.LineDrawing(Line((0,)), "x"), tmp_path / "a")
