# SPDX-License-Identifier: MIT
"""A job beside what boards hold: their registers are read back, each difference is a row."""

import json
from fractions import Fraction

import pytest
from click.testing import CliRunner

import jobbench
from console import Console
from pixstep import natives, ops
from pixstep.cli.main import main
from pixstep.jobs.job import Job
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import SimOptions


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with a machine and its job."""
    folder = tmp_path_factory.mktemp("job")
    machine = jobbench.write_machine(folder)
    jobbench.make(machine).write(folder / "a.pxjob")
    return folder


@pytest.fixture
def mega(simulator):
    """Yield a bus with a simulated Mega."""
    boards = [("mega", natives.image("mega"))]
    with SimLink(SimOptions(boards, Fraction(30))) as found:
        yield found


def rows_of(folder, link, **more):
    """Return the verdict of a comparison and its rows of the board."""
    done = ops.job_check(
        folder / "a.pxjob", machine=folder / "machine.toml", link=link, **more
    )  # fmt: skip
    rows = {one["field"]: one for one in done["fields"] if one["place"] == "board main"}
    return done, rows


def told(row):
    """Return colour, mark and values of a row."""
    return row["colour"], row["key"], row["job"], row["found"]


def test_a_board_as_the_job_wants_it(folder, mega):
    ops.board_set(["sync=2"], link=mega)
    done, rows = rows_of(folder, mega)
    assert done["verdict"] == "green" and done.status == 0
    assert told(rows["kind"]) == ("green", True, "mega", "mega")
    assert told(rows["pixel_hz"])[:2] == ("green", True)
    assert told(rows["lines of M39"]) == ("green", False, "4 lines", "all 4 pass")
    assert not {"unit_address", "dir_setup_us"} & {
        name for name, row in rows.items() if row["colour"] != "green"
    }


@pytest.mark.parametrize(
    ("setting", "field", "colour", "key", "status"),
    [
        ("pixel_hz=31", "pixel_hz", "amber", True, 1),
        ("divider=3", "divider", "amber", True, 1),
        ("sync=0", "sync", "amber", False, 1),
        ("gate_edges=90", "gate_edges", "amber", False, 1),
        ("backlash_policy=1", "backlash_policy", "amber", False, 1),
        ("dir_setup_us=50", "dir_setup_us", "grey", False, 0),
        ("max_acceleration=40", "lines of M39", "red", False, 2),
    ],
)
def test_a_board_that_is_set_otherwise_has_a_row(folder, mega, setting, field, colour, key, status):
    ops.board_set([*(["sync=2"] if field != "sync" else []), setting], link=mega)
    done, rows = rows_of(folder, mega)
    row = rows[field]
    assert (row["colour"], row["key"]) == (colour, key)
    assert row["job"] != row["found"] and row["why"]
    assert done.status == status
    assert rows_of(folder, mega, accept_amber=True)[0].status == (0 if status < 2 else 2)


def test_settings_that_went_into_the_job_are_compared_one_by_one(folder, mega, tmp_path):
    ops.board_set(["sync=2", "dir_setup_us=35"], link=mega)
    ops.board_settings_export(tmp_path / "main.toml", link=mega)
    machine = jobbench.write_machine(tmp_path)
    asked = jobbench.JobOptions(settings={"main": tmp_path / "main.toml"})
    jobbench.make(machine, asked=asked).write(tmp_path / "a.pxjob")
    done, rows = rows_of(tmp_path, mega)
    assert done["verdict"] == "green" and rows["dir_setup_us"]["colour"] == "green"
    assert rows["firmware"]["colour"] == "green"
    ops.board_set(["dir_setup_us=36", "start_stop_steps=60"], link=mega)
    done, rows = rows_of(tmp_path, mega)
    changed = {name for name, row in rows.items() if row["colour"] == "amber"}
    assert changed == {"dir_setup_us", "start_stop_steps"} and done.status == 1


def test_another_kind_of_board_and_none(folder, simulator):
    with SimLink(SimOptions([("uno", natives.image("uno"))], Fraction(30))) as link:
        done, rows = rows_of(folder, link)
        assert told(rows["kind"]) == ("red", True, "mega", "uno")
        assert rows["axis of M41"]["colour"] == "red" and done.status == 2
        text = (folder / "machine.toml").read_text()
        (folder / "other.toml").write_text(text.replace("unit = 1", "unit = 9"))
        done = ops.job_check(folder / "a.pxjob", machine=folder / "other.toml", link=link)
        row = next(one for one in done["fields"] if one["place"] == "board main")
        assert row["colour"] == "red" and "does not answer" in row["why"]


def test_several_boards_have_rows_of_their_own(tmp_path, simulator):
    text = jobbench.MACHINE.replace(
        "[motors.M39]", '[boards.other]\nkind = "uno"\nunit = 2\n\n[motors.M39]'
    ).replace("axis = 0", 'axis = 0\nboard = "main"')
    text = text.replace("axis = 1", 'axis = 1\nboard = "main"').replace(
        "axis = 2", 'axis = 0\nboard = "other"')  # fmt: skip
    machine = jobbench.write_machine(tmp_path, text)
    jobbench.make(machine).write(tmp_path / "a.pxjob")
    boards = [(kind, natives.image(kind)) for kind in ("mega", "uno")]
    with SimLink(SimOptions(boards, Fraction(30))) as link:
        ops.board_set(["sync=2"], units=(1, 2), link=link)
        ops.board_set(["divider=2"], units=2, link=link)
        done = ops.job_check(tmp_path / "a.pxjob", machine=tmp_path / "machine.toml", link=link)
    places = {one["place"] for one in done["fields"]}
    assert places == {"machine.toml", "board main", "board other"}
    wrong = [(one["place"], one["field"]) for one in done["fields"] if one["colour"] == "amber"]
    assert wrong == [("board other", "divider")] and done["verdict"] == "amber"


@pytest.mark.parametrize("number", [1, 2])
def test_the_lines_of_a_job_on_a_simulated_board(folder, tmp_path, monkeypatch, simulator, number):
    """Every edge is where it should be, and the motors end where the job says."""
    monkeypatch.chdir(tmp_path)
    job = Job.read(folder / "a.pxjob")
    ops.job_export(folder / "a.pxjob", line_number=number, out="lines")
    files = [f"lines/{name}.csv" for name in job.motors]
    lines = job.line(number)
    done = ops.sim(
        files, machine=folder / "machine.toml", motor=job.motors, out="run", sync="start",
        negative=lines["M39"].negative,
    )  # fmt: skip
    assert done["verdict"] == "pass"
    for axis, name in zip(done["axes"], job.motors, strict=True):
        assert axis["steps"] == axis["expected_steps"] == lines[name].total_steps
        assert axis["pixels_equal"] == axis["pixels"] == job.pixels  # its records, edge by edge


def test_the_command_asks_at_the_port_of_the_machine_file(folder, mega, monkeypatch):
    monkeypatch.chdir(folder)
    console = Console(monkeypatch, mega.simulator, mega.world)
    monkeypatch.delenv("PIXSTEP_PORT")
    words = ["job", "check", "a.pxjob", "--json"]
    done = CliRunner().invoke(main, words)
    assert console.options == [] and done.exit_code == 0
    done = CliRunner().invoke(main, [*words, "--boards"])
    places = {one["place"] for one in json.loads(done.stdout)["fields"]}
    assert places == {"machine.toml", "board main"} and done.exit_code in (0, 1)
    assert [one.name for one in console.options] == ["/dev/ttyACM0"]
    CliRunner().invoke(main, [*words, "--port", "/dev/ttyUSB7"])
    assert console.options[-1].name == "/dev/ttyUSB7"
    monkeypatch.setenv("PIXSTEP_PORT", "/dev/ttyUSB8")
    CliRunner().invoke(main, ["job", "run", "a.pxjob"])
    assert console.options[-1].name == "/dev/ttyUSB8"
