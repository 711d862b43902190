# SPDX-License-Identifier: MIT
"""Jobs that are made: of images, files of lines, tables and scan specifications."""

import json
from itertools import accumulate, pairwise

import pytest
import useq
from scanspec import specs

import jobbench
from jobbench import image, make, speed
from pixstep import formats, ops
from pixstep.errors import UserError
from pixstep.jobs import judging, line_files, making
from pixstep.jobs.job import Job
from pixstep.jobs.making import AskedImage, JobOptions
from pixstep.lines.line import SMOOTH
from pixstep.profiles import generator

BACKLASH = 250


@pytest.fixture
def machine(tmp_path):
    return jobbench.write_machine(tmp_path)


@pytest.fixture
def in_folder(machine, pixstep):
    """Return the command line in the machine's folder (both are the test's)."""
    return pixstep


def load_edges(job, number, name="M39"):
    """Return where the load is at the edges of the image of a line: pixels + 1 places.

    A motor that moves forth is its play ahead of the load.
    """
    run, line = job.runs_of(number)[name], job.line(number)[name]
    places = [run.start_steps, *job.expected(number, name)]
    begin = run.image_pixel - 1
    play = 0 if line.negative else line.backlash
    return [place - play for place in places[begin : begin + job.header.line.image_pixels + 1]]


@pytest.mark.parametrize("lead_out", [8, 20])
@pytest.mark.parametrize("back", [0, 300, -700, 2000, -1, 1])
def test_lines_forth_and_back_print_the_same_places(machine, back, lead_out):
    """An offset of lines back moves their image by just so many steps."""
    if back % 2:
        with pytest.raises(UserError, match="nearest"):
            make(machine, image(lead_out=lead_out, offset_back=back))
        return
    job = make(machine, image(lead_out=lead_out, offset_back=back))
    forth = load_edges(job, 1)
    assert [b - a for a, b in pairwise(forth)] == [1000] * 30
    assert load_edges(job, 3) == forth
    for number in (2, 4):
        assert load_edges(job, number)[::-1] == [place + back for place in forth]


def test_an_offset_forth_moves_where_lines_begin(machine):
    plain, moved = (make(machine, image(offset_forward=step)) for step in (0, 44))
    assert load_edges(moved, 1) == [place + 44 for place in load_edges(plain, 1)]
    assert load_edges(moved, 2) == load_edges(plain, 2)


def test_lines_go_on_from_where_the_one_before_ends(machine):
    job = make(machine)
    for name in job.motors:
        for number in range(1, job.lines):
            after = job.runs_of(number + 1)[name].start_steps
            assert job.expected(number, name)[-1] == after
    sides = [job.runs_of(number)["M39"].play_side for number in range(1, 5)]
    assert sides == ["-", "+", "-", "+"]


def test_every_line_is_one_that_boards_take(machine):
    job = make(machine)
    assert judging.judge(job, machine, lambda _: machine.path) == []


def test_one_way_has_a_return_after_each_line_but_the_last(machine):
    job = make(machine, image(lines=3, alternate=False))
    purposes = [job.runs_of(number)["M39"].purpose for number in range(1, job.lines + 1)]
    assert purposes == ["image", "return", "image", "return", "image"]
    assert [job.runs_of(n)["M39"].image_pixel for n in (1, 2)] == [25, 0]
    assert load_edges(job, 1) == load_edges(job, 3) == load_edges(job, 5)
    assert [sum(job.line(n)["M41"].counts) for n in range(1, 6)] == [0, 40, 0, 40, 0]
    assert [any(job.line(n)["M40"].counts) for n in range(1, 6)] == [True, False, True, False, True]


def test_a_motor_steps_after_the_image_and_not_after_the_last_line(machine):
    job = make(machine)
    for number in range(1, 5):
        line, run = job.line(number)["M41"], job.runs_of(number)["M41"]
        end = run.image_pixel - 1 + 30
        assert not any(line.counts[:end])
        assert sum(line.counts) == (40 if number < 4 else 0)


def test_lead_ins_grow_until_a_motor_that_steps_has_the_time(machine):
    """4,000 steps at 100 a pixel take 44 pixels: lead-in 8 and 16 pixels of ramp are too few."""
    wanted = AskedImage(image(), {"M39": speed()}, {"M41": 4000})
    made = making.of_image(machine, wanted, JobOptions())
    assert any(note.startswith("lead-out") for note in made.notes)
    assert any(note.startswith("lead-in") for note in made.notes)
    for number in (1, 2):
        run, line = made.job.runs_of(number)["M41"], made.job.line(number)["M41"]
        assert sum(line.counts[run.image_pixel - 1 + 30 :]) == 4000


def test_a_motor_turns_in_the_middle_of_the_image(machine):
    job = make(machine)
    for number in (1, 2):
        places = [0, *accumulate(job.line(number)["M40"].counts)]
        assert max(places) == 400 and places[-1] == 0 and min(places) == 0
        middle = job.runs_of(number)["M40"].image_pixel - 1 + 15
        assert places[middle] == 400
    with pytest.raises(UserError, match="M40 turns in the middle of the image"):
        make(machine, image(lead_in=0, pixels=4), turns={"M40": 12_000})


def test_a_turning_motor_with_a_hard_first_pixel_gets_advice(machine):
    slow = generator.slow_first_pixels
    assert slow("M40", [10, 25, 60, 110, 110, 60]) == ""
    assert "its first pixel accelerates by 60 steps/px2" in slow("M40", [60, 110, 160, 110, 60])
    assert slow("M40", [60]) == slow("M40", []) == ""
    assert not [note for note in _notes(machine) if "first pixel" in note]
    formats.write_prn(machine.path.parent / "turn.PRN", [60, 110, 160])
    assert [note for note in _notes(machine) if "first pixel" in note]


def _notes(machine):
    wanted = AskedImage(image(), {"M39": speed()}, {}, {"M40": 400})
    return making.of_image(machine, wanted, JobOptions()).notes


def test_several_motors_scan_and_the_image_is_at_the_same_pixels(machine):
    scans = {"M39": speed(), "M41": speed("60")}
    job = make(machine, scans=scans, steps={}, turns={}, still=("M40",))
    begin = job.runs_of(1)["M41"].image_pixel - 1
    assert set(job.line(1)["M41"].counts[begin : begin + 30]) == {60}
    assert set(job.line(2)["M41"].counts[begin : begin + 30]) == {-60}
    assert job.expected(2, "M41")[-1] == 0 and not any(job.line(1)["M40"].counts)
    with pytest.raises(UserError, match="of one scanning motor only"):
        make(machine, image(offset_back=4), scans=scans, steps={}, turns={})


def test_the_motors_direction_is_in_the_lines(tmp_path):
    text = jobbench.MACHINE.replace('direction = "+"', 'direction = "-"').replace(
        'axis = 2\n', 'axis = 2\ndirection = "-"\n')  # fmt: skip
    job = make(jobbench.write_machine(tmp_path, text))
    assert [job.line(n)["M39"].negative for n in (1, 2)] == [True, False]
    assert sum(job.line(1)["M41"].counts) == -40


def test_a_backlash_of_its_own_and_none(machine):
    job = make(machine, asked=JobOptions(backlash={"M39": 100}))
    assert job.line(1)["M39"].backlash == 100 and job.header.motors["M39"].backlash == 100
    job = make(machine, asked=JobOptions(backlash={"M39": 0}))
    assert job.line(1)["M39"].counts[0] == 4
    with pytest.raises(UserError, match="backlash 1100 does not fit one pixel at speed 1000"):
        make(machine, asked=JobOptions(backlash={"M39": 1100}))


def test_make_says_what_it_made(in_folder, machine):
    words = ("job", "make", "--image-size", "30x4", "--scan", "M39=75mm/s", "--step", "M41=0.1mm",
             "--turn", "M40=32deg", "--lead-in", 8, "-o", "a.pxjob")  # fmt: skip
    data = json.loads(in_folder(*words, "--json"))
    assert (data["lines"], data["pixels"], data["motors"]) == (4, 78, ["M39", "M40", "M41"])
    assert data["id"] == make(machine).header.id
    assert "already exists" in in_folder(*words, status=2)
    done = ops.job_make(
        image_size="30x4", scan=["M39=75mm/s"], step=[("M41", "0.1mm")], turn=["M40=32deg"],
        lead_in=8, output="b.pxjob", machine="machine.toml",
    )  # fmt: skip
    assert done["id"] == data["id"] and isinstance(done.value, Job)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--scan", "M39=1000"), "a job is made of one of --image-size, --lines-of"),
        (("--image-size", "30", "--scan", "M39=1000"), "expected PIXELSxLINES"),
        (("--image-size", "0x4", "--scan", "M39=1000"), "a pixel and a line at least"),
        (("--image-size", "30x4"), "an image needs a motor that scans, or one that turns"),
        (("--image-size", "30x4", "--scan", "M39"), "expected NAME=SPEED"),
        (("--image-size", "30x4", "--scan", "M39=fast"), "speed 'fast': expected a number"),
        (("--image-size", "30x4", "--scan", "M7=10"), "there is no motor 'M7': M39, M40, M41"),
        (("--image-size", "30x4", "--scan", "M39=10", "--still", "M39"), "one of them"),
        (("--image-size", "30x4", "--scan", "M39=1001"), "nearest legal 1000 and 1002"),
        (("--image-size", "30x4", "--scan", "M39=11.31mm/s"), "motor M39: speed 11.31mm/s"),
        (("--image-size", "30x4", "--scan", "M39=10", "--scan", "M39=12"), "named twice"),
        (("--image-size", "30x4", "--scan", "M41=0"), "motor M41: speed 0 is outside 1..16382"),
        (("--image-size", "30x4", "--turn", "M39=10"), "only a plain motor turns"),
        (("--image-size", "30x4", "--scan", "M39=1000", "--step", "M41=0"), "a move of 0 steps"),
        (("--image-size", "30x4", "--scan", "M39=1000", "--step", "M41=1deg"), "motor M41: dist"),
        (("--image-size", "30x4", "--scan", "M39=10", "--backlash-of", "M40=3"), "of a smooth"),
        (("--image-size", "30x4", "--scan", "M39=10", "--axis-of", "M40=x"), "not with"),
        (("--table", "t.csv", "--scan", "M39=10"), "--scan: not with --table"),
        (("--image-size", "30x4", "--scan", "M39=1000", "--settings", "x=turn.PRN"),
         "there is no board 'x': main"),
    ],
)  # fmt: skip
def test_misuse_is_one_line(in_folder, machine, words, said):
    formats.write_csv(machine.path.parent / "t.csv", [1])
    told = in_folder("job", "make", *words, "-o", "a.pxjob", status=2)
    assert said in told and told.count("\n") == 1
    assert not (machine.path.parent / "a.pxjob").exists()


def test_lines_that_the_machine_refuses_are_not_written(in_folder, machine):
    text = jobbench.MACHINE.replace("1200 steps/px", "900 steps/px")
    jobbench.write_machine(machine.path.parent, text)
    words = ("job", "make", "--image-size", "30x4", "--scan", "M39=1000", "-o", "a.pxjob")
    assert "line 1 of motor M39: too_fast at pixel" in in_folder(*words, status=3)
    assert "too_fast" in in_folder(*words, "--no-check")


def test_lead_in_of_the_move_profiles_header_comes_first(in_folder, machine):
    header = formats.ProfileHeader("Thu Nov 26 12:00:00 2026", "M39", 1, 3, 6, "30")
    formats.write_csv(machine.path.parent / "move.csv", [4, 12], header)
    words = ("--profile", jobbench.PROFILE, "--speed", "1000", "--pixels", "60", "--json")
    data = json.loads(in_folder("line", "make", "--motor", "M39", *words, "-o", "l.csv"))
    assert data["image_pixel"] == 1 + 15 + 6 + 1
    in_folder("job", "make", "--image-size", "30x2", "--scan", "M39=1000", "-o", "a.pxjob")
    assert Job.read(machine.path.parent / "a.pxjob").header.line.lead_in == 6


def test_exported_lines_make_the_same_job(in_folder, machine):
    folder = machine.path.parent
    make(machine).write(folder / "a.pxjob")
    in_folder("job", "export", "a.pxjob", "--out", "lines")
    words = [word for name in ("M39", "M40", "M41")
             for word in ("--lines-of", f"{name}=lines/{name}.csv")]  # fmt: skip
    in_folder("job", "make", *words, "-o", "b.pxjob")
    first, again = (Job.read(folder / name) for name in ("a.pxjob", "b.pxjob"))
    for number in range(1, 5):
        for name, line in again.line(number).items():
            wanted = first.line(number)[name]
            assert line == wanted
    assert again.runs_of(1)["M39"].image_pixel == first.runs_of(1)["M39"].image_pixel


def test_files_say_their_own_backlash(in_folder, machine):
    folder = machine.path.parent
    make(machine, asked=JobOptions(backlash={"M39": 120})).write(folder / "a.pxjob")
    in_folder("job", "export", "a.pxjob", "--of", "M39", "--line", 1, "--out", "lines")
    told = in_folder("job", "make", "--lines-of", "M39=lines/M39.csv", "-o", "b.pxjob")
    assert "its own backlash of 120 steps is taken; machine.toml has 250" in told
    assert Job.read(folder / "b.pxjob").line(1)["M39"].backlash == 120


def with_header(folder, motor, hz):
    """Write lines of 60 pixels that say what they were made for; return the file."""
    header = formats.ProfileHeader("Thu Nov 26 12:00:00 2026", motor, 1, 0, 0, hz)
    formats.write_csv(folder / "own.csv", [0, *[4] * 58, 0], header)
    return folder / "own.csv"


def test_a_file_for_another_clock_is_refused_as_line_check_does(machine, pixstep):
    with_header(machine.path.parent, "M41", "15")
    said = "own.csv: made for 15 Hz, used at 30 Hz: its accelerations per second are 4 times"
    assert said in pixstep("line", "check", "own.csv", "--motor", "M41", status=3)
    words = ("job", "make", "--lines-of", "M41=own.csv", "-o", "b.pxjob")
    assert said in pixstep(*words, status=3)
    assert said in pixstep(*words, "--no-check")
    told = pixstep("job", "check", "b.pxjob", "--all", status=2)
    assert "red: 1 difference" in told and "motors.M41 file pixel" in told
    with_header(machine.path.parent, "M41", "60")
    assert "made for 60 Hz, used at 30 Hz" in pixstep(*words, "--force")
    found = json.loads(pixstep("job", "check", "b.pxjob", "--json", status=1))
    (row,) = [one for one in found["fields"] if one["colour"] != "green"]
    assert (row["colour"], row["job"], row["found"]) == ("amber", "60 Hz", "30 Hz")


def test_a_file_for_another_motor_is_amber(machine, pixstep):
    with_header(machine.path.parent, "M40", "30")
    said = "own.csv: made for motor M40, used for motor M41"
    assert said in pixstep("job", "make", "--lines-of", "M41=own.csv", "-o", "b.pxjob")
    found = json.loads(pixstep("job", "check", "b.pxjob", "--json", status=1))
    (row,) = [one for one in found["fields"] if one["colour"] != "green"]
    assert (row["colour"], row["job"], row["found"]) == ("amber", "M40", "M41")


def test_files_of_other_lengths_are_refused(machine):
    folder = machine.path.parent
    formats.write_csv(folder / "a.csv", [0, 10, 10, 0])
    formats.write_csv(folder / "b.csv", [0, 10, 0])
    with pytest.raises(UserError, match="has 3 pixels, line 1 of motor M40 4"):
        line_files.of_files(
            machine, {"M40": folder / "a.csv", "M41": folder / "b.csv"}, JobOptions()
        )


TABLE = """\
line,M40 [deg],M41_mm
1,0,0
1,0.8,0.0025
1,1.6,0.005
2,1.6,0.005
2,0.8,0.0025
2,0,0.0025
"""


def test_a_table_of_positions(machine, put):
    job = making_of_table(machine, put(TABLE.encode(), "t.csv"))
    assert (job.lines, job.pixels) == (2, 2)
    assert job.line(1)["M40"].counts == (10, 10) and job.line(2)["M40"].counts == (-10, -10)
    assert job.line(2)["M41"].counts == (-1, 0)


def making_of_table(machine, path):
    pass

    return line_files.of_table(machine, path, JobOptions()).job


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("2,1.6,", "2,2.4,", r"t.csv:5: column 2 'M40 \[deg\]': '2.4': the line begins 10 steps"),
        ("2,0,0.0025", "3,0,0.0025", "a line has two rows at least"),
        ("2,1.6", "4,1.6", "lines are numbered one by one: 2"),
        ("M40 [deg]", "M40 [mrad]", "'mrad' is not a unit"),
        ("M40 [deg]", "M40 [mm]", "needs a motor's steps per mm"),
        ("1,0.8", "1,x", "not a number"),
        ("M40 [deg],M41_mm", "a_deg,b_mm", "no column is called as a motor"),
    ],
)
def test_a_wrong_table_is_refused_with_its_place(machine, put, old, new, said):
    with pytest.raises(UserError, match=said):
        making_of_table(machine, put(TABLE.replace(old, new, 1).encode(), "t.csv"))


USEQ = {
    "stage_positions": [{"x": 100_000.0, "y": 200_000.0, "z": 0.0}],
    "grid_plan": {"rows": 3, "columns": 40, "fov_width": 2500.0, "fov_height": 100.0,
                  "mode": "row_wise_snake"},
    "channels": ["DAPI"],
}  # fmt: skip


def test_a_useq_sequence(in_folder, machine):
    folder = machine.path.parent
    (folder / "u.json").write_text(useq.MDASequence(**USEQ).model_dump_json())
    in_folder("job", "make", "--useq", "u.json", "--axis-of", "M39=x", "--axis-of", "M41=y",
              "--turn", "M40=200", "--lead-in", 8, "-o", "u.pxjob")  # fmt: skip
    job = Job.read(folder / "u.pxjob")
    assert (job.lines, job.header.line.image_pixels, job.header.motors["M39"].speed) == (
        3,
        40,
        1000,
    )
    assert load_edges(job, 1)[0] == 50 * 400 and load_edges(job, 1)[-1] == 150 * 400
    assert load_edges(job, 2)[::-1] == load_edges(job, 1)
    assert job.runs_of(1)["M41"].start_steps == round(200.1 * 400)
    assert job.runs_of(2)["M41"].start_steps == 200 * 400
    assert job.header.source.files.keys() == {"u.json"}


def test_a_scanspec_specification(in_folder, machine):
    folder = machine.path.parent
    spec = specs.Linspace("M41", 0, 2, 5) * specs.Linspace("M39", 50.0, 1, 50)
    (folder / "s.json").write_text(json.dumps(spec.serialize()))
    in_folder("job", "make", "--scanspec", "s.json", "--lead-in", 8, "-o", "s.pxjob")
    job = Job.read(folder / "s.pxjob")
    assert (job.lines, job.header.line.alternate, job.header.motors["M39"].speed) == (9, False, 400)
    assert job.line(1)["M39"].negative and not job.line(2)["M39"].negative
    assert job.header.motors["M41"].distance == 200
    edges = load_edges(job, 1)
    assert (edges[0], edges[-1]) == (round(50.5 * 400), 200)


@pytest.mark.parametrize(
    ("spec", "said"),
    [
        (specs.Linspace("M39", 0, 5, 6), "two are wanted, as motors are called"),
        (specs.Linspace("M41", 0, 2, 3) * specs.Linspace("M7", 0, 5, 6), "axis M7: no motor"),
        (specs.Linspace("M41", 0, 2, 3).zip(specs.Linspace("M39", 0, 5, 3)), "place 2: one"),
        (specs.Linspace("M41", 0, 0.0001, 3) * specs.Linspace("M39", 0, 5, 6), "not a whole"),
        (specs.Linspace("M41", 0, 2, 3) * specs.Linspace("M39", 0, 1, 7), "speed of .* a pixel"),
    ],
)  # fmt: skip
def test_a_specification_that_is_no_image(in_folder, machine, spec, said):
    (machine.path.parent / "s.json").write_text(json.dumps(spec.serialize()))
    with pytest.raises(UserError, match=said):
        ops.job_make(scanspec="s.json", output="s.pxjob", machine="machine.toml")


def test_smooth_lines_are_smooth(machine):
    job = make(machine)
    line = job.line(1)["M39"]
    assert line.decode == SMOOTH and line.backlash == BACKLASH and line.speeds[-1] == 0


def test_smooth_lines_of_files_run_forth_and_back(in_folder, machine):
    folder = machine.path.parent
    in_folder("line", "make", "--motor", "M39", "--speed", 1000, "--pixels", 60, "--lines", 3,
              "-o", "m.csv")  # fmt: skip
    for words, backwards in (((), [False, True, False]), (("--one-way",), [False] * 3)):
        in_folder("job", "make", "--lines-of", "M39=m.csv", *words, "-o", "m.pxjob", "--force")
        job = Job.read(folder / "m.pxjob")
        assert [job.line(number)["M39"].negative for number in (1, 2, 3)] == backwards


def test_a_smooth_motor_may_step(machine):
    text = jobbench.MACHINE.replace("limits.max_speed = \"1200", "limits.max_acceleration = "
                                    "\"100 steps/px2\"\nlimits.max_speed = \"1200")  # fmt: skip
    machine = jobbench.write_machine(machine.path.parent, text)
    job = make(machine, scans={"M41": speed("60")}, steps={"M39": -500}, turns={})
    line = job.line(1)["M39"]
    assert line.negative and sum(line.counts) == 500 and line.backlash == 0
    assert job.runs_of(4)["M39"].start_steps == -1500
    assert judging.judge(job, machine, lambda _: machine.path) == []


@pytest.mark.parametrize(
    ("of", "motions", "said"),
    [
        (image(pixels=300_000_000), {}, "lines of 300000048 pixels: a line has 2000000 at most"),
        (image(lines=30_000_000), {}, "30000000 lines: a job has 99999 at most"),
        (image(lead_in=2_000_000), {}, "a line has 2000000 at most"),
        (image(), {"steps": {"M41": 10**9}}, "motor M41: 1000000000 steps at 100 steps/px at most"),
    ],
)
def test_lines_that_are_too_long_or_too_many(machine, of, motions, said):
    with pytest.raises(UserError, match=said):
        make(machine, of, **motions)


def test_a_place_that_no_board_can_count_to_is_refused(machine):
    with pytest.raises(UserError, match="line 1 of motor M41 ends at 2147483648 steps"):
        make(machine, asked=JobOptions(starts={"M41": 2**31 - 40}))


def test_settings_that_are_none_are_refused(in_folder, machine):
    (machine.path.parent / "x.toml").write_text("[settings]\ncolour = 3\n")
    words = ("--image-size", "30x4", "--scan", "M39=1000", "--settings", "main=x.toml")
    assert "x.toml:2: no setting 'colour'" in in_folder(
        "job", "make", *words, "-o", "a.pxjob", status=3
    )


def test_motors_of_any_name(tmp_path, pixstep):
    text = jobbench.MACHINE.replace("motors.M39", 'motors."axis 1"').replace(
        "motors.M40", 'motors."a/b"').replace("motors.M41", 'motors."Z=\u00fc"')  # fmt: skip
    jobbench.write_machine(tmp_path, text)
    pixstep("job", "make", "--image-size", "30x4", "--scan", "axis 1=1000", "--step",
            "Z=\u00fc=-40", "--turn", "a/b=400", "--lead-in", 8, "-o", "a.pxjob")  # fmt: skip
    pixstep("job", "export", "a.pxjob", "--out", "e")
    assert {path.name for path in (tmp_path / "e").glob("*.csv")} == {
        "axis_1.csv", "a_b.csv", "Z_\u00fc.csv"
    }  # fmt: skip
    assert "a.pxjob: green" in pixstep("job", "check", "a.pxjob")
