# SPDX-License-Identifier: MIT
"""A job beside the machine of today: each field alone, all pairs, unknown and missing keys."""

import json
import re
from itertools import combinations

import pytest
from rich.console import Console

import jobbench
from pixstep import formats, ops
from pixstep.errors import RefusedError
from pixstep.jobs import comparison
from pixstep.jobs.comparison import AMBER, GREEN, GREY, RED
from pixstep.jobs.job import Job
from pixstep.jobs.machine_copy import MachineCopy
from pixstep.operations.job.check import KEY_MARK, LEGEND, STYLES

STATUS = {GREEN: 0, GREY: 0, AMBER: 1, RED: 2}
KEY = True

# What is changed in the machine file, the row that shows it, colour, key field, words of why.
CHANGES = [
    ('pixel = "30 Hz"', 'pixel = "31 Hz"', "clock.pixel", RED, KEY, "per pixel of the job's"),
    ("divider = 1", "divider = 2", "clock.divider", RED, KEY, "so many edges"),
    ('sync = "lock"', 'sync = "start"', "clock.sync", AMBER, False, "in another way"),
    ("lead_in = 4", "lead_in = 5", "line.lead_in", AMBER, False, "have their own"),
    ("pixels = 80", "pixels = 90", "line.pixels", GREY, False, "other commands"),
    ("/dev/ttyACM0", "/dev/ttyACM1", "boards.main.port", GREY, False, "where the board"),
    ("unit = 1", "unit = 2", "boards.main.unit", GREY, False, "where the board"),
    ("axis = 0", "axis = 3", "motors.M39.axis", RED, KEY, "on another axis"),
    ('kind = "smooth"', 'kind = "plain"', "motors.M39.kind", RED, KEY, "decoded in another"),
    ("400 steps/mm", "500 steps/mm", "motors.M39.steps_per_unit", RED, KEY, "another length"),
    ('direction = "+"', 'direction = "-"', "motors.M39.direction", RED, KEY, "the other way"),
    ('"250 steps"', '"100 steps"', "motors.M39.backlash", AMBER, KEY, "the job's 250 steps are"),
    ('"250 steps"', '"0 steps"', "motors.M39.backlash", RED, KEY, "does not have"),
    ('"250 steps"', '"1001 steps"', "motors.M39.backlash", RED, KEY, "a pixel at 1000 steps/px"),
    ("1200 steps/px", "1100 steps/px", "motors.M39.limits.max_speed", AMBER, False, "still keep"),
    ("1200 steps/px", "900 steps/px", "motors.M39 lines", RED, False, "is refused by what"),
    ("axis = 1", "axis = 1\nbacklash = 3", "motors.M40.backlash", AMBER, False, "no line of this"),
    ("axis = 1", 'axis = 1\nhome_is_limit = "plus"', "motors.M40.home_is_limit", AMBER, False,
     "another switch"),
    ("axis = 1", 'axis = 1\nword = "A"', "motors.M40.word", GREY, False, "other commands"),
    ("[motors.M40]", "[motors.M42]", "motors.M40", RED, False, "does not have it any more"),
    ("axis = 1", "axis = 1\ncolour = 3", "motors.M40.colour", AMBER, False, "does not know"),
    ("[line]", "[new.table]\nkey = 1\n[line]", "new", AMBER, False, "does not know the key"),
    ("divider = 1\n", "", "clock.divider", AMBER, KEY, "missing today; its default is the same"),
    ('direction = "+"\n', "", "motors.M39.direction", AMBER, KEY, "missing today"),
    ("axis = 1\n", 'axis = 1\ndirection = "+"\n', "motors.M40.direction", AMBER, KEY,
     "missing in the job"),
    ("unit = 1\n", "", "boards.main.unit", GREEN, False, ""),
    ("lead_in = 4\n", "", "line.lead_in", AMBER, False, "have their own"),
    ('limits.max_speed = "1200 steps/px"\n', "", "motors.M39.limits.max_speed", AMBER, False,
     "still keep"),
    ('"30 Hz"', '"0.03 kHz"', "clock.pixel", GREEN, KEY, ""),
    ('"400 steps/mm"', '"2.5 um/step"', "motors.M39.steps_per_unit", GREEN, KEY, ""),
    ("axis = 1", 'axis = 1\nepics.name = "m40"', "motors.M40.epics.name", GREY, False,
     "other commands"),
    ("axis = 1", "axis = 1\nepics.fields = { DLLM = 0 }", "motors.M40.epics.fields.DLLM", GREY,
     False, "other commands"),
    ("[line]", '[motors.M7]\naxis = 3\nkind = "plain"\n[line]', "motors.M7.axis", GREY, False,
     "not in the job"),
    ("[line]", '[epics]\nprefix = "x:"\n[line]', "epics.prefix", GREY, False, "other commands"),
    ("[clock]", "# a remark\n[clock]", "file", GREY, False, "comments or layout"),
]  # fmt: skip


def compare(job, text, folder):
    """Return the rows of a job beside a machine file in a folder."""
    return comparison.with_machine(job, MachineCopy.of(text.encode(), folder / "machine.toml"))


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Return the job of the machine as it is, read from its file."""
    folder = tmp_path_factory.mktemp("job")
    machine = jobbench.write_machine(folder)
    jobbench.make(machine).write(folder / "a.pxjob")
    return Job.read(folder / "a.pxjob")


@pytest.fixture
def compared(made, tmp_path):
    """Return a function that compares the job with a changed machine file: rows by field."""
    jobbench.write_machine(tmp_path)

    def changed(*changes):
        text = jobbench.MACHINE
        for old, new in changes:
            assert old in text, old
            text = text.replace(old, new, 1)
        rows = compare(made, text, tmp_path)
        return {row.field: row for row in rows}

    return changed


def test_the_same_machine_is_green(compared):
    rows = compared()
    assert {row.colour for row in rows.values()} == {GREEN}
    keys = {name.rpartition(".")[2] for name, row in rows.items() if row.key}
    wanted = {"pixel", "divider", "kind", "board", "axis", "steps_per_unit", "direction",
              "backlash", "line sha256"}  # fmt: skip
    assert keys == wanted


@pytest.mark.parametrize(("old", "new", "field", "colour", "key", "why"), CHANGES)
def test_each_field_alone(compared, old, new, field, colour, key, why):
    rows = compared((old, new))
    found = rows[field]
    assert (found.colour, found.key) == (colour, key)
    assert why in found.why and (why or not found.why)
    assert colour is GREEN or found.job != found.found or "default" in found.why
    worst = comparison.verdict(rows.values())
    assert worst >= (GREEN if colour is GREY else colour)
    others = [row for row in rows.values() if row.colour > GREEN and row is not found]
    others = [row for row in others if not row.field.startswith("motors.M7.")]
    if colour in (AMBER, GREY) or field.startswith("motors.M39.backlash"):
        assert others == [] and worst is comparison.verdict([found])


def test_all_pairs(compared):
    """Two changes at once have the rows of both, and the worse verdict."""
    tried = 0
    alone = {one[:3]: comparison.verdict(compared(one[:2]).values()) for one in CHANGES}
    for first, second in combinations(CHANGES, 2):
        try:
            rows = compared(first[:2], second[:2])
        except (AssertionError, RefusedError):
            continue  # both change one key, or what is left is no machine
        for _, _, field, colour, key, _ in (first, second):
            if field == "file" or field not in rows:
                continue  # comments beside a difference; a motor that is gone has no fields
            assert rows[field].colour >= (colour if colour is not AMBER else GREY), field
            assert rows[field].key == key
        worse = max(alone[first[:3]], alone[second[:3]])
        assert comparison.verdict(rows.values()) is worse, (first, second)
        tried += 1
    assert tried > 400


def test_a_backlash_where_the_job_has_none(made, tmp_path):
    machine = jobbench.write_machine(tmp_path, jobbench.MACHINE.replace('"250 steps"', '"0 steps"'))
    job = jobbench.make(machine)
    job = _written(job, tmp_path)
    rows = compare(job, jobbench.MACHINE, tmp_path)
    found = next(row for row in rows if row.field == "motors.M39.backlash")
    assert (found.colour, found.key) == (RED, True)
    assert "no room to take play up" in found.why


def _written(job, folder):
    job.write(folder / "b.pxjob")
    return Job.read(folder / "b.pxjob")


def test_another_kind_of_board(tmp_path):
    text = jobbench.MACHINE.partition("[motors.M41]")[0]
    of_mega = jobbench.write_machine(tmp_path, text)
    job = _written(jobbench.make(of_mega, steps={}), tmp_path)
    rows = compare(job, text.replace('"mega"', '"m1284"'), tmp_path)
    found = next(row for row in rows if row.field == "boards.main.kind")
    assert (found.colour, found.key, found.found) == (RED, True, "m1284")
    rows = compare(job, text.replace("boards.main", "boards.other"), tmp_path)
    colours = {row.field: row.colour for row in rows}
    assert colours["boards.main"] is colours["motors.M39.board"] is RED


@pytest.mark.parametrize(
    ("name", "field", "colour", "key"),
    [
        ("AccProfM39-30Hz-1.PRN", "motors.M39.profiles.line sha256", RED, True),
        ("turn.PRN", "motors.M40.profiles.line sha256", RED, True),
        ("move.csv", "motors.M39.profiles.move sha256", AMBER, False),
        ("home.csv", "motors.M39.profiles.home sha256", AMBER, False),
    ],
)
def test_profiles_by_their_content(compared, tmp_path, name, field, colour, key):
    rows = compared()
    assert rows[field].colour is GREEN
    data = (tmp_path / name).read_bytes()
    (tmp_path / name).write_bytes(data[:-3] + b"9" + data[-2:])
    found = compared()[field]
    assert (found.colour, found.key) == (colour, key)
    (tmp_path / name).unlink()
    found = compared()[field]
    assert found.colour is colour and "No such file" in found.found


def test_haps_have_a_row(compared, tmp_path):
    header = formats.ProfileHeader(**{**vars(jobbench.HEADER), "haps": 2})
    formats.write_csv(tmp_path / "home.csv", [2, 4, 6, 8], header)
    found = compared()["motors.M39.profiles.home HAPs"]
    assert (found.colour, found.job, found.found) == (AMBER, "3", "2")


def test_a_profile_of_another_name_and_the_same_content_is_grey(compared, tmp_path):
    (tmp_path / "other.PRN").write_bytes((tmp_path / "turn.PRN").read_bytes())
    rows = compared(('"turn.PRN"', '"other.PRN"'))
    assert rows["motors.M40.profiles.line"].colour is GREY
    assert rows["motors.M40.profiles.line sha256"].colour is GREEN
    assert comparison.verdict(rows.values()) is GREEN


def test_a_profile_that_was_named_for_the_job_is_no_difference(made, tmp_path):
    machine = jobbench.write_machine(tmp_path)
    formats.write_prn(tmp_path / "own.PRN", [8, 16, 32, 64, 128, 256, 512, 1000])
    asked = jobbench.JobOptions(profiles={"M39": tmp_path / "own.PRN"})
    job = _written(jobbench.make(machine, asked=asked), tmp_path)
    rows = compare(job, jobbench.MACHINE, tmp_path)
    assert comparison.verdict(rows) is GREEN
    assert job.header.motors["M39"].used == "own"


def test_a_wrong_value_of_today_is_refused(made, tmp_path):
    for text, said in (
        (jobbench.MACHINE.replace('"30 Hz"', '"x Hz"'), "clock.pixel = 'x Hz': "),
        (jobbench.MACHINE.replace("axis = 1", "axis = 9"), "motors.M40.axis = 9: "),
        ("x = ", "machine.toml: "),
    ):
        with pytest.raises(RefusedError, match=said):
            compare(made, text, tmp_path)


def test_what_moves_asks_for_agreement(made, compared):
    """A run refuses red, and amber that nobody agreed to, in one line."""
    green, amber = compared(), compared(('"250 steps"', '"100 steps"'))
    red = compared(('"30 Hz"', '"31 Hz"'))
    comparison.require(made, green.values(), accept_amber=False)
    comparison.require(made, amber.values(), accept_amber=True)
    with pytest.raises(RefusedError, match=r"amber: .*backlash: the job has 250 steps, found 100"):
        comparison.require(made, amber.values(), accept_amber=False)
    with pytest.raises(RefusedError, match=r"red: .*clock.pixel"):
        comparison.require(made, red.values(), accept_amber=True)


@pytest.fixture
def in_folder(pixstep, tmp_path):
    """Return the command line in a folder with a job and its machine."""
    machine = jobbench.write_machine(tmp_path)
    jobbench.make(machine).write(tmp_path / "a.pxjob")
    return pixstep


@pytest.mark.parametrize(
    ("old", "new", "verdict", "status"),
    [
        ("lead_in", "lead_in", "green", 0),
        ("/dev/ttyACM0", "/dev/ttyACM1", "green", 0),
        ('"250 steps"', '"100 steps"', "amber", 1),
        ('"30 Hz"', '"31 Hz"', "red", 2),
        ("lead_in = 4", "lead_in = 4\ncolour = 3", "amber", 1),
        ("[clock]", "# remark\n[clock]", "green", 0),
    ],
)
def test_exit_status_json_and_text(in_folder, tmp_path, old, new, verdict, status):
    (tmp_path / "machine.toml").write_text(jobbench.MACHINE.replace(old, new, 1))
    data = json.loads(in_folder("job", "check", "a.pxjob", "--json", status=status))
    assert data["verdict"] == verdict
    text = in_folder("job", "check", "a.pxjob", status=status)
    assert f"a.pxjob: {verdict}" in text and f"{KEY_MARK} key field" in text
    assert "\x1b" not in text
    rows = [line for line in text.splitlines() if line.lstrip().startswith(KEY_MARK)]
    assert len(rows) >= sum(one["key"] for one in data["fields"])
    agreed = {"amber": 0}.get(verdict, status)
    text = in_folder("job", "check", "a.pxjob", "--accept-amber", status=agreed)
    assert ("accepted" in text) == (verdict == "amber")
    assert ops.job_check("a.pxjob", machine="machine.toml").status == status


def test_all_shows_every_field(in_folder):
    few, many = in_folder("job", "check", "a.pxjob"), in_folder("job", "check", "a.pxjob", "--all")
    assert "line.lead_in" not in few and "line.lead_in" in many
    assert "fields more are equal" in few and "fields more are equal" not in many


def test_colours_and_bold_on_a_terminal_only(in_folder, tmp_path):
    (tmp_path / "machine.toml").write_text(
        jobbench.MACHINE.replace('"250 steps"', '"100 steps"', 1)
        .replace("/dev/ttyACM0", "/dev/ttyACM1").replace("lead_in = 4", "lead_in = 5")
        .replace('"30 Hz"', '"31 Hz"')
    )  # fmt: skip
    done = ops.job_check(tmp_path / "a.pxjob", machine=tmp_path / "machine.toml")
    console = Console(force_terminal=True, color_system="standard", width=160)

    class Screen:
        def tell(self, text):
            console.print(text)

        def draw(self, what, *, wide=False):
            console.print(what)

        def styled(self, text, *, colour=None, bold=None):
            return text

    with console.capture() as captured:
        done.text(Screen())
    lines = captured.get().splitlines()
    codes = {"red": "31", "yellow": "33", "green": "32", "bright_black": "90"}
    for field, colour, bold in (
        ("clock.pixel", "red", True), ("M39.backlash", "amber", True),
        ("line.lead_in", "amber", False), ("boards.main.port", "grey", False),
        ("M41.axis", "green", True),
    ):  # fmt: skip
        line = next(one for one in lines if field in one)
        styles = set(re.findall(r"\x1b\[([0-9;]+)m", line))
        code = codes[STYLES[colour]]
        assert (f"1;{code}" if bold else code) in styles, (field, styles)
        assert (KEY_MARK in line) == bold
    assert " ".join(LEGEND.split()) in " ".join(captured.get().split())


def test_a_damaged_job_is_status_3(in_folder, tmp_path):
    data = bytearray((tmp_path / "a.pxjob").read_bytes())
    data[len(data) // 2] ^= 1
    (tmp_path / "a.pxjob").write_bytes(bytes(data))
    for command in ("check", "show", "show-config"):
        told = in_folder("job", command, "a.pxjob", status=3)
        assert "a.pxjob: damaged in member" in told and told.count("\n") == 1


def test_show_config_gives_the_files_back(in_folder, tmp_path):
    text = in_folder("job", "show-config", "a.pxjob", "--out", "files")
    assert 'backlash = "250 steps"' in text and "lead_in = 8" in text
    for name in ("machine.toml", "turn.PRN", "home.csv"):
        assert (tmp_path / "files" / name).read_bytes() == (tmp_path / name).read_bytes()
    data = json.loads(in_folder("job", "show-config", "a.pxjob", "--json"))
    assert data["header"]["schema"] == 1 and data["files"][0]["name"] == "machine.toml"


def test_show_tells_motors_times_and_a_line(in_folder, tmp_path):
    data = json.loads(in_folder("job", "show", "a.pxjob", "--line", 2, "--json"))
    assert (data["lines"], data["pixels"], data["seconds"]) == (4, 78, 10.4)
    assert [one["role"] for one in data["motors"]] == ["scan", "turn", "step"]
    line = {one["motor"]: one for one in data["line"]}
    job = Job.read(tmp_path / "a.pxjob")
    assert tuple(line["M39"]["expected"]) == job.expected(2, "M39")
    text = in_folder("job", "show", "a.pxjob", "--line", 2)
    assert "line 2, motor M39: smooth, backwards, image from pixel 25; from 55086" in text
    told = in_folder("job", "show", "a.pxjob", "--line", 5, status=2)
    assert "line 5: there are lines 1 to 4" in told
