# SPDX-License-Identifier: MIT
"""The report of a run: one small file that asks no network, is ready at once, and tells the truth.

What it draws is read off the page, in a browser, as a reader does.
"""

import base64
import gzip
import hashlib
import json
import random
import re
from html import escape

import numpy as np
import pyarrow
import pyarrow.parquet as parquet
import pytest

import browser
import jobbench
import reportbench
import runbench
from pixstep import natives, ops
from pixstep.errors import RefusedError, UserError
from pixstep.jobs.job import Job
from pixstep.jobs.report import page
from pixstep.jobs.run_folder import RunFolder

MOST_BYTES, MOST_MS = 3_000_000, 2_000
VENDORED = {
    "uplot-1.6.32.min.js": "19c8d4c6ad88929a79f4ae49d6f7161566dfd0ba3d15cc495e974f787eb78f1f",
    "uplot-1.6.32.min.css": "df630c6a8d6f8eeaff264b50f73ce5b114f646ffd9a0bb74f049b0a00135fa04",
}


@pytest.fixture(scope="module")
def chromium():
    """Return a browser for all tests."""
    with browser.opened() as found:
        yield found


@pytest.fixture
def job(tmp_path):
    """Return a job of four lines in a folder with its machine."""
    machine = jobbench.write_machine(tmp_path)
    jobbench.make(machine).write(tmp_path / "a.pxjob")
    return Job.read(tmp_path / "a.pxjob")


def report(made, **more):
    """Return the report of a run and its page."""
    path = made.folder.path.with_suffix(".html")
    return ops.job_report(made.folder.path, output=path, **more), path.read_text("utf-8")


def first_text(html):
    """Return the first text of a page's body, as it is written."""
    return re.match(r"(?:\s|<[^>]*>)*([^<]*)<", html.partition("<body>")[2])[1]


def arrays(html):
    """Return the arrays of a page."""
    about = json.loads(re.search(r'id="about">(.*?)</script>', html)[1])
    data = gzip.decompress(base64.b64decode(re.search(r'id="data">(.*?)</script>', html)[1]))
    return about, {
        one["name"]: np.frombuffer(
            data, f"<{np.dtype(one['type']).str[1:]}", one["count"], one["at"]
        )
        for one in about["arrays"]
    }


def noise(seed=44):
    """Return records with noise on the edges, and nothing off its place."""
    chance = random.Random(seed)
    return lambda line, motor, pixel: (0, max(-9, min(9, round(chance.gauss(0, 1.5)))))


@pytest.fixture(scope="module")
def large(tmp_path_factory):
    """Return the report of 200 lines of 3 motors with 500 pixels, all of which have records."""
    folder = tmp_path_factory.mktemp("large")
    machine = jobbench.write_machine(folder)
    jobbench.large(machine, lines=200, pixels=500).write(folder / "big.pxjob")
    made = reportbench.finished(folder / "big.pxrun", Job.read(folder / "big.pxjob"))
    made.record(range(1, 201), noise())
    return report(made)[0]


def test_it_is_small_ready_at_once_and_asks_no_network(large, chromium):
    assert large["records"] == 300_000 and large["bytes"] < MOST_BYTES
    times = [chromium.open(large["output"]) for _ in range(3)]
    print(f"{large['bytes']} bytes, ready after {times} ms")
    assert min(times) < MOST_MS
    assert chromium.asked == [f"file://{large['output']}"] and chromium.errors == []
    assert chromium.run("document.body.innerText").startswith("Finished: 200 of 200 lines")


@pytest.mark.parametrize("width", [1280, 390])
def test_it_fits_the_screen_and_has_six_drawings(large, chromium, width):
    chromium.open(large["output"], width=width)
    assert chromium.run("document.documentElement.scrollWidth") == width
    titles = chromium.run("[...document.querySelectorAll('.pane h3')].map(x => x.innerText)")
    assert [one.split()[0] for one in titles] == [
        "Speed", "Position", "Edge", "Expected", "Actual", "Measured",
    ]  # fmt: skip
    assert chromium.run("document.querySelectorAll('.pane canvas').length") == 5
    axes = chromium.run(
        "[...document.querySelectorAll('.pane')].filter(x => x.querySelector('canvas'))"
        ".map(x => x.querySelectorAll('.u-axis').length)"
    )
    assert axes == [2] * 5


def test_a_drag_zooms_all_drawings_and_a_double_click_shows_all(large, chromium):
    chromium.open(large["output"])
    chromium.drag(".pane .u-over", 0.25, 0.5)
    found = dict(re.findall(r"(\w+)=([^&]*)", chromium.run("location.hash")))
    assert 110 < float(found["from"]) < 140 and 240 < float(found["to"]) < 260
    chromium.run("document.getElementById('whole').click()")
    assert "from=0&to=500" in chromium.run("location.hash")


def test_a_page_that_wanted_to_ask_a_network_could_not(large, chromium):
    chromium.open(large["output"])
    refused = (
        "new Promise((done) => { document.addEventListener('securitypolicyviolation', "
        "(event) => done(event.effectiveDirective)); %s })"
    )
    for what, directive in (
        ("fetch('http://127.0.0.1:9/').catch(() => 0)", "connect-src"),
        ("new Image().src = 'http://127.0.0.1:9/a.png'", "img-src"),
    ):
        assert chromium.run(refused % what) == directive


def shown_at(chromium, pane, share):
    """Return what a drawing says of the pixel at a share of its width."""
    chromium.call(
        "Input.dispatchMouseEvent", type="mouseMoved", **dict(zip("xy", chromium.run(
            f"(() => {{ const one = document.querySelectorAll('.pane')[{pane}]"
            ".querySelector('.u-over'); one.scrollIntoView({block: 'center'});"
            "const box = one.getBoundingClientRect();"
            f"return [box.x + {share} * box.width, box.y + box.height / 2]; }})()"
        ), strict=True)),
    )  # fmt: skip
    said = f"document.querySelectorAll('.pane')[{pane}].querySelector('output').innerText"
    chromium.run("new Promise((done) => requestAnimationFrame(() => setTimeout(done, 20)))")
    pixel, value = re.match(r"pixel (\d+): (-?[\d,.]+)", chromium.run(said)).groups()
    return int(pixel), float(value.replace(",", ""))


def test_what_is_drawn_is_what_the_job_and_the_records_say(job, tmp_path, chromium):
    made = reportbench.finished(tmp_path / "a.pxrun", job)
    made.record(
        [1, 2], lambda line, motor, pixel: (2 if (line, pixel) == (2, 40) else 0, pixel % 7)
    )
    _, html = report(made)
    chromium.open(made.folder.path.with_suffix(".html"), fragment="#line=2&motor=M39&map=off")
    places = [job.runs_of(2)["M39"].start_steps, *job.expected(2, "M39")]
    seen = set()
    for share in (0.1, 0.3, 40 / 78, 0.8, 0.97):
        pixel, speed = shown_at(chromium, 0, share)
        seen.add(pixel)
        assert speed == places[pixel] - places[pixel - 1]
        assert shown_at(chromium, 1, share) == (pixel, pytest.approx(places[pixel] / 400, abs=6e-5))
        assert shown_at(chromium, 2, share) == (pixel, pixel % 7)
        assert shown_at(chromium, 3, share) == (pixel, places[pixel])
        assert shown_at(chromium, 4, share) == (pixel, places[pixel] + 2 * (pixel == 40))
    assert 40 in seen and len(seen) == 5
    about, found = arrays(html)
    assert about["fates"] == [1, 1, 1, 1] and list(found["row"][6:]) == [-1] * 6


def test_a_run_on_a_board_is_reported(tmp_path, simulator):
    del simulator
    job = runbench.folder_with_job(tmp_path, pixels=10)
    text = (tmp_path / "machine.toml").read_text().replace('"250 steps"', '"100 steps"')
    (tmp_path / "machine.toml").write_text(text)
    with runbench.bus() as link:
        assert runbench.run(tmp_path, link, records=True)["state"] == "finished"
    done = ops.job_report(tmp_path / "a.pxrun", output=tmp_path / "a.html")
    html = (tmp_path / "a.html").read_text("utf-8")
    assert first_text(html) == "Finished: 4 of 4 lines printed"
    assert (done["colour"], done.status, done["strange"]) == ("amber", 1, 0)
    assert done["records"] > 300 and done["worst_off_steps"] == done["worst_error_ticks"] == 0
    assert "the job&#x27;s 250 steps are sent" in html and 'class="amber key"' in html
    assert f"{job.lines} lines of {job.pixels} pixels; boards: main (mega" in html


def test_the_first_text_is_the_verdict_and_its_colour_that_of_the_worst(job, tmp_path):
    cases = []
    made = reportbench.finished(tmp_path / "good.pxrun", job)
    cases.append((made, "green", "Finished: 4 of 4 lines printed"))
    made = reportbench.MadeUp(tmp_path / "skipped.pxrun", job)
    made.print(1, 2, 3)
    made.add("skip", line=4, was="broken at pixel 9 of 78")
    made.finish()
    cases.append((made, "amber", "Finished, not whole: 3 of 4 lines printed; skipped: 4"))
    made = reportbench.MadeUp(tmp_path / "paused.pxrun", job)
    made.print(1, 2)
    made.add("paused", line=2)
    cases.append((made, "amber", "Paused after line 2: 2 of 4 lines printed, 5.2 s left"))
    made = reportbench.MadeUp(tmp_path / "broken.pxrun", job)
    made.print(1)
    made.add("stopped", line=2, why="board 1: <reset> & gone", motors=[])
    cases.append((made, "red", "Broken off: 1 of 4 lines printed; board 1: <reset> & gone"))
    made = reportbench.MadeUp(tmp_path / "died.pxrun", job)
    made.print(1)
    made.add("stopped", line=2, why="an older reason", motors=[])
    made.add("resume", comparison="green")
    made.print(2)
    no_reason = "; the log says no reason, as when a computer dies"
    cases.append((made, "red", f"Broken off: 2 of 4 lines printed{no_reason}"))
    made = reportbench.finished(tmp_path / "strange.pxrun", job)
    made.record([3], noise())
    table = parquet.read_table(next(made.folder.path.rglob("*3.parquet")))
    values = table["expected_steps"].to_numpy() + 1
    table = table.set_column(2, "expected_steps", pyarrow.array(values, pyarrow.int32()))
    parquet.write_table(table, next(made.folder.path.rglob("*3.parquet")))
    cases.append((made, "red", "Finished: 4 of 4 lines printed"))
    for made, colour, verdict in cases:
        done, html = report(made)
        assert (done["colour"], done["verdict"]) == (colour, verdict)
        assert done.status == (colour in ("amber", "red"))
        assert first_text(html) == escape(verdict)
        assert f'<header class="{colour}">' in html


def test_a_page_of_a_run_in_progress_loads_itself_again(job, tmp_path, chromium, monkeypatch):
    monkeypatch.setattr(page, "_RELOAD_S", 1)
    made = reportbench.MadeUp(tmp_path / "a.pxrun", job)
    made.print(1)
    with made.folder.log():
        done, html = report(made)
    assert done["colour"] == "blue" and "Running: line 2 of 4, " in html
    path = made.folder.path.with_suffix(".html")
    chromium.open(path, fragment="#line=3&motor=M40&map=speed&from=10&to=30")
    assert "reloads itself every 1 s" in chromium.run("document.body.innerText")
    made.print(2, 3, 4)
    made.finish()
    report(made)
    while not chromium.run("document.body.innerText").startswith("Finished: 4 of 4"):
        chromium.await_event("Page.loadEventFired")
    assert "reloads itself" not in chromium.run("document.body.innerText")
    assert "line=3&motor=M40&map=speed&from=10&to=30" in chromium.run("location.hash")


def test_what_was_measured_is_drawn_beside_what_was_expected(job, tmp_path, chromium):
    made = reportbench.finished(tmp_path / "a.pxrun", job)
    rows = [
        f"3,M39,{k},{at + (5 if k == 39 else 0)}" for k, at in enumerate(job.expected(3, "M39"), 1)
    ]
    table = tmp_path / "m.csv"
    table.write_text("\n".join(["line,motor,pixel,measured_steps", *rows]) + "\n")
    done, _ = report(made, measured=table)
    assert done["measured"] == 78
    chromium.open(done["output"], fragment="#line=3&motor=M39&map=measured")
    said = chromium.run("document.querySelectorAll('.pane')[5].innerText")
    assert "at most 5 steps off" in said
    assert shown_at(chromium, 5, 0.5) == (39, job.expected(3, "M39")[38] + 5)
    table.write_bytes(job.path.read_bytes())
    with pytest.raises(RefusedError, match=r"m\.csv: no table, as Parquet .* line, motor, pixel"):
        report(made, measured=table)
    with pytest.raises(UserError, match=r"nowhere\.csv: No such file"):
        report(made, measured=tmp_path / "nowhere.csv")
    table.write_text("line,motor,pixel\n1,M39,1\n")
    with pytest.raises(RefusedError, match=r"m\.csv: no column measured_steps: line, motor, pixel"):
        report(made, measured=table)
    table.write_text("line,motor,pixel,measured_steps\n1,M39,1,5\n1,M9,1,5\n")
    with pytest.raises(RefusedError, match=r"row 2: line 1, motor M9, pixel 1: the job has lines"):
        report(made, measured=table)
    table.write_text("line,motor,pixel,measured_steps\n1,M39,1,x\n")
    with pytest.raises(RefusedError, match="measured_steps: whole numbers are needed"):
        report(made, measured=table)


def test_names_are_text(job, tmp_path):
    made = reportbench.finished(tmp_path / "<b>{{verdict}}&.pxrun", job)
    _, html = report(made)
    assert "&lt;b&gt;{{verdict}}&amp;.pxrun" in html and "<b>{{verdict}}" not in html


def test_it_begins_with_the_name_of_the_run_unless_said(pixstep, job, tmp_path):
    reportbench.finished(tmp_path / "a.pxrun", job)
    said = pixstep("job", "report", "a.pxrun")
    assert said == "a.html: Finished: 4 of 4 lines printed\n"
    assert (tmp_path / "a.html").read_text("utf-8").startswith("<!doctype html>")
    with pytest.raises(UserError, match="no run of a job"):
        ops.job_report(tmp_path, output=tmp_path / "b.html")
    (tmp_path / "a.pxrun" / "parts").mkdir()
    (tmp_path / "a.pxrun" / "parts" / "line-000001.parquet").write_text("x")
    with pytest.raises(RefusedError, match=r"line-000001\.parquet: no records of a run: "):
        ops.job_report(tmp_path / "a.pxrun", output=tmp_path / "b.html")


def test_the_charts_are_those_of_their_release_and_the_page_has_their_licence(job, tmp_path):
    folder = natives.root() / "tools/src/pixstep/data/report"
    for name, wanted in VENDORED.items():
        assert hashlib.sha256((folder / name).read_bytes()).hexdigest() == wanted
    _, html = report(reportbench.finished(tmp_path / "a.pxrun", job))
    assert "Copyright (c) 2022 Leon Sorokin" in html and "THE SOFTWARE IS PROVIDED" in html
    assert not re.search(
        r"""(?:src|href)\s*=|url\(|import\(|@import""", html.partition("uPlot:")[0]
    )


class TestWatch:
    """`pixstep watch` beside a run."""

    def test_a_run_that_has_ended_is_one_look(self, pixstep, job, tmp_path):
        reportbench.finished(tmp_path / "a.pxrun", job)
        assert pixstep("watch", "a.pxrun") == "a.pxrun: Finished: 4 of 4 lines printed\n"

    def test_each_line_is_a_row_and_the_page_follows(self, job, tmp_path, monkeypatch):
        made = reportbench.MadeUp(tmp_path / "a.pxrun", job)
        todo = [lambda n=n: made_line(made, log, n) for n in range(1, 5)]
        pages = []

        def sleep(_seconds):
            pages.append((tmp_path / "a.html").read_text("utf-8"))
            if todo:
                todo.pop(0)()
            else:
                log.add({"event": "finished", "line": 4, "at": made.at_s, "s": 0})
                log.close()

        monkeypatch.setattr("pixstep.operations.job.watch.time.sleep", sleep)
        monkeypatch.setattr("pixstep.operations.job.watch._PAGE_S", 0.0)
        log = made.folder.log()
        done = ops.watch(made.folder.path, page=tmp_path / "a.html")
        texts = [one["text"].partition(": ")[2] for one in done["looks"]]
        assert [text.partition(",")[0] for text in texts] == [
            "Running: line 1 of 4", "Running: line 2 of 4", "Running: line 3 of 4",
            "Running: line 4 of 4", "Running: line 4 of 4", "Finished: 4 of 4 lines printed",
        ]  # fmt: skip
        assert [one["left_s"] for one in done["looks"]] == sorted(
            (one["left_s"] for one in done["looks"]), reverse=True
        )
        assert ["Running: line 3 of 4" in html for html in pages] == [False] * 2 + [True] + [
            False
        ] * 2
        assert "Finished: 4 of 4 lines printed" in (tmp_path / "a.html").read_text("utf-8")

    def test_what_is_left_counts_the_line_that_moves(self, job, tmp_path, monkeypatch):
        made = reportbench.MadeUp(tmp_path / "a.pxrun", job)
        made.print(1)
        made.add("queued", line=2)
        line_s = job.pixels / 30
        for passed_s, left_s in ((0.0, 3.0), (1.0, 3 - 1 / line_s), (100.0, 2.0)):
            monkeypatch.setattr(
                "pixstep.jobs.report.story.time.time", lambda s=passed_s: made.at_s + s
            )
            with made.folder.log():
                (look,) = ops.watch(made.folder.path, once=True)["looks"]
            assert look["line"] == 2 and look["left_s"] == round(left_s * line_s, 1)

    def test_a_broken_run_is_status_1(self, pixstep, job, tmp_path):
        made = reportbench.MadeUp(tmp_path / "a.pxrun", job)
        made.print(1)
        said = json.loads(pixstep("watch", "a.pxrun", "--json", status=1).splitlines()[0])
        assert (said["state"], said["printed"], said["line"]) == ("broken", 1, 2)
        assert RunFolder.of(tmp_path / "a.pxrun").history().state(is_running=False) == "broken"


def made_line(made, log, line):
    """Log a line as queued and made, in a log that is open."""
    made.at_s += 1
    for event in ("queued", "done"):
        log.add({"event": event, "line": line, "at": made.at_s, "s": 0})
