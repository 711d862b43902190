# SPDX-License-Identifier: MIT
"""The per-pixel records of lines that run on boards: all of them, or every Nth, in a file."""

import csv
import json
from fractions import Fraction
from itertools import accumulate
from pathlib import Path

import numpy as np
import pytest

import pixstep as px
from console import PORT, put
from pixstep import natives
from pixstep.board import recording
from pixstep.board import registers as regs
from pixstep.board.recording import COLUMNS, AxisLog
from pixstep.board.state import NewestRecords, Record
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import SimOptions

PIXELS = 60


@pytest.fixture
def on_board(make_console):
    """Return a function that starts an image and returns its link and a console on it."""
    links = []

    def start(kind, hz):
        link = SimLink(SimOptions([(kind, natives.image(kind))], Fraction(hz)))
        links.append(link)
        return link, make_console(link.simulator, link.world)

    yield start
    for link in links:
        link.close()


def rows_of(path):
    """Return the records of a CSV file by axis."""
    with Path(path).open(encoding="ascii", newline="") as file:
        reader = csv.reader(file)
        assert tuple(next(reader)) == COLUMNS
        found = {}
        for row in reader:
            unit, line, axis, *record = map(int, row)
            found.setdefault((unit, line, axis), []).append(tuple(record))
    return found


def exact(found):
    """Return records without the errors of clock edges, of which none is more than a tick."""
    assert all(abs(error) <= 1 for rows in found.values() for *_, error in rows)
    return {key: [(*row, 0) for *row, _ in rows] for key, rows in found.items()}


def every(counts, step=1):
    """Return the records of a line that is made as it should be."""
    places = enumerate(accumulate(counts), 1)
    return [(pixel, place, place, 0) for pixel, place in places if pixel % step == 0]


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize(
    ("kind", "hz", "axes", "step"),
    [
        ("mega", 30, 1, 1), ("mega", 30, 4, 1), ("mega", 80, 2, 1), ("mega", 100, 4, 2),
        ("mega", 1000, 1, 10), ("mega", 1000, 4, 34), ("uno", 30, 1, 1), ("uno", 400, 1, 9),
        ("m1284", 200, 2, 3),
    ],
)  # fmt: skip
def test_every_record_of_a_line_on_a_board(on_board, kind, hz, axes, step):
    pixels = max(PIXELS, hz)
    lines = [[2 + (pixel * (axis + 3)) % 5 for pixel in range(pixels)] for axis in range(axes)]
    names = [put(counts, f"{axis}.csv") for axis, counts in enumerate(lines)]
    _, console = on_board(kind, hz)
    done = console.run("upload", *names, "--decode", "plain", "--arm", "--records", "r.csv",
                       "--pixel-hz", hz, "--beyond")  # fmt: skip
    found = rows_of("r.csv")
    assert exact(found) == {(1, 1, axis): every(one, step) for axis, one in enumerate(lines)}
    said = f"board 1: records of every {step} pixels and of every deviation"
    assert (said in done.stderr) is (step > 1)
    assert done.stdout.endswith(f"r.csv: {axes * (pixels // step)} records, none missed\n")
    assert "overwritten" not in done.stderr
    assert console.out("get", "record_every") == "record_every = 1 px\n"


@pytest.mark.usefixtures("simulator")
def test_lines_one_after_the_other_are_told_apart(on_board):
    """What is left of the line before is in no file of the next."""
    _, console = on_board("mega", 100)
    for number, count in ((1, 3), (2, 5), (3, 2)):
        put([count] * PIXELS)
        console.out("upload", "line.csv", "--decode", "plain", "--pixel-hz", 100)
        done = console.json("start", "--wait", "--records", f"{number}.csv")
        facts = done["boards"][0]["axes"][0]["records"]
        assert facts == {"read": 60, "missed": 0, "every_px": 1, "max_difference_steps": 0}
        assert exact(rows_of(f"{number}.csv")) == {(1, number, 0): every([count] * PIXELS)}


@pytest.mark.usefixtures("simulator")
def test_boards_that_start_together_lose_none(make_console):
    """A short line on an Uno, which keeps eight records, is over soon after the boards agree."""
    kinds = [(kind, natives.image(kind)) for kind in ("mega", "uno")]
    link = SimLink(SimOptions(kinds, Fraction(30)))
    try:
        console = make_console(link.simulator, link.world)
        for unit, pixels in ((1, 90), (2, 12)):
            put([3] * pixels)
            console.out("upload", "line.csv", "--decode", "plain", "--unit", unit)
        console.out("start", "--unit", "1,2", "--wait", "--records", "r.csv")
    finally:
        link.close()
    wanted = {(1, 1, 0): every([3] * 90), (2, 1, 0): every([3] * 12)}
    assert exact(rows_of("r.csv")) == wanted


@pytest.mark.usefixtures("simulator")
def test_a_program_s_records(on_board, plan_program):
    Path("machine.toml").write_text(
        f'[clock]\npixel = 100\n[boards.a]\nkind = "mega"\nport = "{PORT}"\n[motors.X]\naxis = 0\n'
        'kind = "plain"\nlimits = { max_acceleration = "40000 steps/s2" }\n'
    )
    Path("p.pmc").write_text("ABS LINEAR TA100 TS0 F400\nX400\nX0\n")
    _, console = on_board("mega", 100)
    console.out("run", "p.pmc", "--records", "r.csv", "--machine", "machine.toml")
    ((place, rows),) = rows_of("r.csv").items()
    assert place == (1, 1, 0) and [row[0] for row in rows] == [*range(1, len(rows) + 1)]
    assert rows[-1][1:] == (0, 0, 0) and max(row[1] for row in rows) > 380
    assert all(row[1] == row[2] for row in rows)


@pytest.mark.usefixtures("simulator")
def test_a_lock_s_records_have_the_edges_errors(on_board):
    """The error of an edge that comes after its pixel is in the record all the same."""
    put([6] * 200)
    _, console = on_board("mega", 100)
    words = ("upload", "line.csv", "--decode", "plain", "--arm", "--records", "r.csv")
    console.out(*words, "--sync", "lock", "--pixel-hz", "100")
    ((_, rows),) = rows_of("r.csv").items()
    later = console.out("log", "records", status=1).split()[1:]
    kept = {int(row.split(",")[2]): tuple(map(int, row.split(",")[2:])) for row in later}
    assert len(kept) == 20 and [row for row in rows if row[0] in kept] == [*kept.values()]


@pytest.mark.usefixtures("simulator")
def test_a_lock_is_not_lost_by_the_setting(on_board):
    """A board measures its clock anew after every change: between locked lines there is none."""
    put([6] * 400)
    link, console = on_board("mega", 500)
    words = ("upload", "line.csv", "--decode", "plain", "--arm", "--sync", "lock", "--json",
             "--pixel-hz", "500")  # fmt: skip
    facts = [json.loads(console.out(*words))["axes"][0]["records"] for _ in range(2)]
    assert facts[0] == facts[1] and facts[0]["every_px"] > 1 and not facts[0]["missed"]
    assert link.board(1).setting("record_every") == facts[0]["every_px"]
    assert regs.is_measured(link.board(1).input("status"))


# Upload, start, run and the interface, without a board's time


@pytest.mark.parametrize("ending", ["csv", "parquet", "CSV"])
def test_both_forms_of_the_file(one, ending):
    put([3] * 90)
    path = f"r.{ending}"
    one.out("upload", "line.csv", "--decode", "plain", "--arm", "--records", path)
    if ending == "parquet":
        table = pytest.importorskip("pyarrow.parquet").read_table(path).to_pydict()
        assert tuple(table) == COLUMNS
        found = [*zip(*(table[name] for name in COLUMNS[3:]), strict=True)]
        assert (set(table["unit"]), set(table["line"]), set(table["axis"])) == ({1}, {1}, {0})
    else:
        found = rows_of(path)[1, 1, 0]
    assert found == every([3] * 90)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("upload", "line.csv", "--decode", "plain", "--records", "r.csv"), "add --arm, without"),
        (("upload", "line.csv", "--decode", "plain", "--arm", "--no-wait", "--records", "r.csv"),
         "add --arm, without --no-wait"),
        (("start", "--records", "r.csv"), "records are read while lines run: add --wait"),
        (("start", "--records", "r.txt", "--wait"), "r.txt: a file of records ends with .csv or"),
        (("upload", "line.csv", "--decode", "plain", "--arm", "--records", "line.csv"),
         "line.csv: is the input"),
        (("upload", "line.csv", "--decode", "plain", "--arm", "--records", "r.csv", "--no-records"),
         "--records and --no-records"),
        (("start", "--wait", "--no-records", "--records", "r.csv"), "--records and --no-records"),
    ],
)  # fmt: skip
def test_what_cannot_be_recorded_is_refused(one, words, said):
    put([3] * 4)
    assert said in one.err(*words, status=2)
    assert not Path("r.csv").exists() and not any(axis.next_block for axis in one.board.axes)


def test_records_up_to_a_fault_are_kept(one):
    put([3] * 90)
    one.world.later(1.5, lambda: one.board.latch("limit_plus", 0, 0, 40))
    words = ("upload", "line.csv", "--decode", "plain", "--arm", "--records", "r.csv")
    assert "limit_plus" in one.err(*words)
    rows = rows_of("r.csv")[1, 1, 0]
    assert 30 < len(rows) < 60 and rows == every([3] * len(rows))


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_a_run_that_does_not_begin_leaves_no_file(one, ending):
    put([3] * 9)
    one.board.latch("limit_plus", 0, 2, 40)
    words = ("upload", "line.csv", "--decode", "plain", "--arm", "--records", f"r.{ending}")
    assert "limit_plus" in one.err(*words)
    assert not Path(f"r.{ending}").exists()
    one.out("clear")
    assert "9 records, none missed" in one.out(*words)


def test_records_up_to_ctrl_c_are_kept(one):
    put([3] * 90)

    def press():
        raise KeyboardInterrupt

    one.world.later(1.5, press)
    words = ("upload", "line.csv", "--decode", "plain", "--arm", "--records", "r.csv")
    assert "stopped by" in one.ended(*words)
    assert one.board.commands[-1][0] == "stop"
    rows = rows_of("r.csv")[1, 1, 0]
    assert 30 < len(rows) < 50 and rows == every([3] * len(rows))


def test_records_that_were_overwritten_are_counted(one):
    put([3] * 90)
    one.board.values["record_capacity"] = 2
    one.out("upload", "line.csv", "--decode", "plain", "--pixel-hz", 300)
    words = ("start", "--wait", "--records", "r.csv")
    done = one.run(*words, status=1)
    rows = rows_of("r.csv")[1, 1, 0]
    missed = 90 - len(rows)
    assert missed > 20 and rows == [row for row in every([3] * 90) if row in rows]
    assert f"note: board 1 axis 0: {missed} records were overwritten before they" in done.stderr
    assert f"r.csv: {len(rows)} records, {missed} missed\n" in done.stdout


def test_the_board_s_own_thinning_stays(one):
    put([3] * 90)
    one.out("set", "record_every=3")
    found = json.loads(one.out("upload", "line.csv", "--decode", "plain", "--arm", "--json"))
    assert found["axes"][0]["records"]["every_px"] == 3
    assert one.board.setting("record_every") == 3


def test_records_can_be_left_out(one):
    put([3] * 90)
    words = ("upload", "line.csv", "--decode", "plain", "--arm", "--no-records", "--json")
    assert json.loads(one.out(*words))["axes"][0]["records"] is None
    bases = {regs.RECORD_BASE + regs.RECORD_STRIDE * axis for axis in range(4)}
    read = {int.from_bytes(data[2:4]) for data in one.line.requests if data[1] == 4}
    assert not bases & read


def test_a_log_counts_what_came_before_it(one):
    put([3] * PIXELS)
    one.out("upload", "line.csv", "--decode", "plain", "--arm")
    done = one.run("log", "records", "--axis", 0, status=1)
    assert done.stdout.split()[1].startswith("1,0,51,")
    assert "10 records; missed: 50 of axis 0, overwritten before they were read" in done.stderr


def test_the_interface_keeps_the_records(one):
    made = px.line([3] * 90, decode="plain", pixel_hz=30)
    with px.connect(PORT) as bus:
        (state,) = bus.board(1).run(made, 2)
        records = state.records
        assert (len(records), records.every, records.missed) == (90, 1, 0)
        assert (records.unit, records.axis, records.pixel.tolist()) == (1, 2, [*range(1, 91)])
        assert np.array_equal(records.expected_steps, 3 * records.pixel)
        assert np.array_equal(records.actual_steps, records.expected_steps)
        assert len(repr(state)) < 200 and len(repr(records)) < 100
        assert bus.board(1).axes()[2].records is None
        assert records.write("r.csv") == Path("r.csv")
    assert rows_of("r.csv") == {(1, 1, 2): every([3] * 90)}


# The arithmetic


def test_how_many_records_can_be_read():
    """The rule: a record lives longer than the time from one look at its axis to the next."""
    found = {
        (hz, axes, capacity): recording.every_of(
            Fraction(hz), axes, capacity, 115_200, streamed=False
        )
        for hz in (30, 100, 500, 5000)
        for axes in (1, 4)
        for capacity in (8, 20)
    }
    assert found[30, 1, 8] == found[100, 1, 20] == 1
    for (hz, axes, capacity), step in found.items():
        more = recording.every_of(Fraction(2 * hz), axes, capacity, 115_200, streamed=False)
        assert step <= more <= 2 * step
        slow = recording.every_of(Fraction(hz), axes, capacity, 19_200, streamed=False)
        streamed = recording.every_of(Fraction(hz), axes, capacity, 115_200, streamed=True)
        assert slow >= step and streamed >= step


def test_a_record_is_given_out_once_it_is_final():
    log = AxisLog(None, 0, 4)

    def look(made, *pixels, ended=False, error=0):
        records = [Record(pixel, pixel, pixel, error) for pixel in pixels]
        rows = log.take(NewestRecords(made, records), ended=ended)
        return [(row.line, row.record.pixel, row.record.edge_error_ticks) for row in rows]

    assert look(0) == [] and look(2, 1, 2) == [(4, 1, 0)]
    assert look(3, 1, 2, 3, error=7) == [(4, 2, 7)]
    assert look(9, 8, 9) == [(4, 3, 7), (4, 8, 0)] and log.missed == 4
    assert look(9, 8, 9, ended=True) == [(4, 9, 0)]
    assert look(2, 1, 2, ended=True) == [(5, 1, 0), (5, 2, 0)] and log.missed == 4
    assert log.rows == 7
