# SPDX-License-Identifier: MIT
"""The live page: what a browser shows is what a simulated board does; who may ask for what.

The board runs in virtual time: a look, a quarter of a second, the next look.
"""

import contextlib
import socket
import time
import urllib.error
import urllib.request
from types import SimpleNamespace

import pytest

import browser
import jobbench
import reportbench
import runbench
from pixstep import ops
from pixstep.board import run, snapshot
from pixstep.board.link import SerialLink
from pixstep.board.port import Port
from pixstep.board.upload import LineUpload
from pixstep.errors import UserError
from pixstep.jobs.job import Job
from pixstep.jobs.report.story import Story
from pixstep.lines.runs import queue_entries
from pixstep.operations.live import serving
from pixstep.operations.live import view as live_view
from pixstep.operations.live.eye import Eye, Spot, names_on
from pixstep.operations.live.job_run import LiveRun
from pixstep.operations.live.view import LiveView
from pixstep.server import remote, web
from pixstep.server.web import Bell, Site
from serverbench import Desk, until

LOOK_S, LOOKS = 0.25, 24
TOKEN = "a-token"
MOST_BYTES, MOST_MS = 100_000, 2_000
HANG_S = 60


class Scene:
    """A run of a job whose first line moves on a simulated board, and the page that shows it."""

    def __init__(self, folder, link):
        machine = jobbench.write_machine(folder)
        jobbench.make(machine, jobbench.image(20, 200, 20)).write(folder / "a.pxjob")
        job = Job.read(folder / "a.pxjob")
        made = reportbench.MadeUp(folder / "a.pxrun", job)
        made.add("queued", line=1)
        self.board = link.board()
        tables = job.machine.tables
        for motor, line in job.line(1).items():
            upload = LineUpload(self.board, tables[motor].axis, queue_entries(line))
            upload.push()
        self.link, self.job, self.bell = link, job, Bell()
        snapshot.await_measured(self.board, link.world, 1 / 30)
        run.arm(self.board, [0, 1, 2], 0)
        names = names_on(tables, "/dev/ttyACM0")
        self.eye = Eye(Spot(Port("/dev/ttyACM0"), (1,), names), link, LOOK_S, self.bell.ring)
        with made.folder.log():
            self.run = LiveRun("a.pxrun", job, Story.of(made.folder, job))
        self.view = LiveView([self.eye], self.run, "a.pxrun", stops=True)

    def look(self, looks=1):
        for _ in range(looks):
            self.link.world.wait(LOOK_S)
            self.eye.look()


@contextlib.contextmanager
def served(view, bell, **more):
    """Yield a site that shows a view."""
    site = Site(("127.0.0.1", 0), serving.text(), view, bell, TOKEN, **more)
    site.open()
    try:
        yield site
    finally:
        site.close()


@pytest.fixture(scope="module")
def scene(tmp_path_factory, simulator):
    del simulator
    with runbench.bus() as link:
        made = Scene(tmp_path_factory.mktemp("live"), link)
        made.look(LOOKS)
        yield made


@pytest.fixture(scope="module")
def chromium():
    with browser.opened() as found:
        yield found


@pytest.fixture
def site(scene, monkeypatch):
    monkeypatch.setattr(live_view, "STALE_S", HANG_S)  # the board's time passes in looks alone
    scene.look()
    with served(scene.view, scene.bell, stop=scene.view.stop) as made:
        yield made


def text_of(chromium, selector):
    return chromium.run(f"document.querySelector({selector!r}).innerText")


def test_the_page_is_small_ready_at_once_and_asks_nobody_else(site, chromium):
    times = [chromium.visit(site.address) for _ in range(3)]
    asked = chromium.asked
    print(f"{len(site.page)} bytes, {len(site.packed)} packed, ready after {times} ms")
    assert len(site.page) < MOST_BYTES and min(times) < MOST_MS and chromium.errors == []
    assert asked == [site.address, site.address.replace("/?", "/events?")]


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1280, 390])
def test_it_fits_the_screen_and_draws_every_motor(
    site, scene, chromium, width, scheme, tmp_path
):  # fmt: skip
    chromium.visit(site.address, width=width, scheme=scheme)
    assert chromium.run("document.documentElement.scrollWidth") == width
    titles = chromium.run("[...document.querySelectorAll('.pane h3 b')].map(x => x.innerText)")
    assert titles == ["M39", "M40", "M41", "Axis 3"]
    assert chromium.run("document.querySelectorAll('canvas').length") == 4
    paper = "getComputedStyle(document.body).backgroundColor.match(/\\d+/g).map(Number)"
    assert (sum(chromium.run(paper)) > 600) == (scheme == "light")
    chromium.picture(tmp_path / "page.png")
    assert (tmp_path / "page.png").stat().st_size > 20_000


def test_figures_are_those_of_the_board(site, scene, chromium):
    chromium.visit(site.address)
    assert text_of(chromium, "h1").startswith("Running: line 1 of 20, ")
    position = scene.board.axis(0)["position_steps"]
    steps = scene.eye.seen[1].now.axes[0]["position_steps"]
    assert 0 < steps <= position
    shown = float(text_of(chromium, ".pane .figures b").replace(",", ""))
    assert shown == pytest.approx(steps / 400, abs=0.0006)
    assert f"mm ({steps:,} steps)" in text_of(chromium, ".pane .figures")
    cards = text_of(chromium, ".cards")
    assert "30 Hz\nset to 30 Hz, " in cards and "fault\nnone" in cards
    assert "line 1 of 20 drawn below" in text_of(chromium, "#place")


def test_the_line_is_drawn_where_the_job_has_it(scene):
    """What was seen of the line lies on what the line is to be, at each pixel that was seen."""
    plan = scene.view.now()["plan"]
    assert plan["line"] == 1
    wanted = [0, *scene.job.expected(1, "M39")]
    assert [places for _, places in plan["motors"]["M39"]] == wanted
    seen = scene.view.first()["past"]["trails"]["/dev/ttyACM0 1 0"]["places"]
    assert len(seen) > LOOKS // 2
    for pixel, position in seen:
        low, high = sorted((wanted[pixel], wanted[min(pixel + 1, len(wanted) - 1)]))
        assert low - 1 <= position <= high + 1, pixel


def test_speeds_are_those_of_the_line(scene):
    """At the line's constant speed: 1000 steps in each pixel of 1/30 s."""
    speeds = scene.view.first()["past"]["trails"]["/dev/ttyACM0 1 0"]["speeds"]
    assert max(speed for _, speed in speeds) == pytest.approx(30_000, rel=0.02)


def ask(site, path, token=TOKEN, data=None):
    """Return status and text of a request."""
    place = site.address.partition("?")[0] + path + (f"?token={token}" if token else "")
    try:
        with urllib.request.urlopen(place, data, timeout=HANG_S) as reply:
            return reply.status, reply.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


def test_who_does_not_know_the_token_sees_nothing(site):
    for path, data in (("", None), ("events", None), ("stop", b"")):
        for token in ("", "wrong", "%C3%A4"):
            status, said = ask(site, path, token, data)
            assert status == 403 and "?token=" in said
    assert ask(site, "nowhere")[0] == ask(site, "x", data=b"")[0] == 404
    assert ask(site, "")[0] == 200


class Silent:
    """A view of nothing, large."""

    def first(self):
        return {"past": "x" * 100_000}

    def now(self):
        return {"look": str(time.monotonic())}


def test_a_page_without_a_button_stops_nothing():
    with served(Silent(), Bell()) as made:
        assert ask(made, "stop", data=b"") == (404, "This page only shows.\n")


def stream(site):
    """Return a connection that has asked for the events."""
    link = socket.create_connection(site.server_address, HANG_S)
    link.sendall(f"GET /events?token={TOKEN} HTTP/1.0\r\n\r\n".encode())
    return link


def test_a_browser_that_never_reads_is_let_go_and_delays_nobody(monkeypatch):
    monkeypatch.setattr(web._Request, "timeout", 0.5)
    bell = Bell()
    with served(Silent(), bell) as made:
        deaf = [stream(made) for _ in range(3)]
        for one in deaf:
            one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
        with stream(made) as hears, hears.makefile("rb") as lines:
            looks = 0
            while looks < 2:
                bell.ring()
                looks += next(lines).startswith(b"event: look")
        free = web.MOST_BROWSERS
        until(lambda: bell.ring() or made.places._value == free, "they are let go")
        for one in deaf:
            one.close()


def test_one_browser_too_many_is_told_so():
    with served(Silent(), Bell()) as made:
        links = [stream(made) for _ in range(web.MOST_BROWSERS)]
        until(lambda: made.places._value == 0, "all watch")
        assert ask(made, "events") == (503, f"{web.MOST_BROWSERS} browsers watch already.\n")
        for one in links:
            one.close()


def test_a_place_that_is_taken_is_named():
    with served(Silent(), Bell()) as made:
        place = made.server_address
        with pytest.raises(UserError, match=rf"127\.0\.0\.1:{place[1]}: Address already in use"):
            Site(place, "", Silent(), Bell(), TOKEN)


@pytest.fixture
def desk(terminal, runtime):
    made = Desk(terminal, timeout_s=0.05)
    yield made
    made.close()


def test_a_board_that_is_gone_is_said_and_comes_back(desk, chromium):
    link = SerialLink(desk.client(), desk.terminal.name)
    bell = Bell()
    eye = Eye(Spot(Port(desk.terminal.name), (1,)), link, 0.05, bell.ring)
    view = LiveView([eye], None, "here", stops=False)
    eye.begin()
    with served(view, bell) as made:
        chromium.visit(made.address)
        told = "document.getElementById('verdict').innerText"
        until(lambda: chromium.run(told) == "At rest: 4 axes, no fault", "it is seen")
        desk.terminal.plan = lambda number, frame, reply: []
        until(lambda: chromium.run(told) == "No figures of board 1", "it is missed")
        assert chromium.run("document.getElementById('head').className") == "red"
        assert chromium.run("document.querySelectorAll('section.stale').length") == 1
        assert text_of(chromium, "#more").startswith(f"board 1 on {desk.terminal.name} (115200")
        desk.terminal.plan = lambda number, frame, reply: [(0, reply)]
        until(lambda: chromium.run(told) == "At rest: 4 axes, no fault", "it is back")
    until(lambda: chromium.run(told).startswith("No connection to pixstep for "), "it is alone")
    assert chromium.run("document.body.className") == "alone"
    eye.close()


def test_the_button_stops_all_boards(desk, chromium):
    link = SerialLink(desk.client(), desk.terminal.name)
    eye = Eye(Spot(Port(desk.terminal.name), (1,)), link, 0.05, lambda: None)
    view, bell = LiveView([eye], None, "here", stops=True), Bell()
    eye.look()
    with served(view, bell, stop=view.stop) as made:
        chromium.visit(made.address)
        chromium.run("document.getElementById('stop').click()")
        said = "document.getElementById('notes').innerText"
        until(lambda: "stop sent to all boards" in chromium.run(said), "it is said")
    assert sum(frame[0] == 0 for frame in desk.frames()) >= 1


def test_a_run_without_a_server_shows_its_log_and_says_why(scene, runtime):
    eye = Eye(Spot(Port("/dev/nowhere"), (1,), served=True), None, LOOK_S, lambda: None)
    view = LiveView([eye], scene.run, "a.pxrun", stops=False)
    assert remote.find(Port("/dev/nowhere")) is None
    eye.begin()
    until(lambda: eye.seen[1].trouble, "it has looked")
    look = view.now()["look"]
    eye.close()
    assert look["verdict"]["text"].startswith("Running: line 1 of 20")
    (note,) = look["notes"]
    assert note["colour"] == "amber" and "no server has /dev/nowhere" in note["more"]


def test_what_does_not_go_together_is_refused(tmp_path, monkeypatch):
    monkeypatch.delenv("PIXSTEP_PORT", raising=False)
    for given, said in (
        ({}, r"run_path is missing, or web"),
        ({"allow_stop": True, "run_path": tmp_path}, "add web"),
        ({"web": True}, "port is missing"),
        ({"web": True, "once": True}, "a page is looked at until Ctrl-C"),
        ({"web": True, "page": tmp_path / "a.html"}, "name the run"),
        ({"web": True, "port": "/dev/nowhere", "at": 0}, "there is no such port"),
    ):
        with pytest.raises(UserError, match=said):
            ops.watch(**given)


def test_the_command_serves_what_it_prints(desk, tmp_path, monkeypatch):
    """Its address is the first row; the token is that of the file; Ctrl-C is its usual end."""
    monkeypatch.chdir(tmp_path)
    seen = []

    def sleep(_seconds):
        with urllib.request.urlopen(seen[0], timeout=HANG_S) as reply:
            seen.append(reply.read())
        raise KeyboardInterrupt

    monkeypatch.setattr("pixstep.operations.job.watch.time", SimpleNamespace(sleep=sleep))
    monkeypatch.setattr(
        "pixstep.operations.live.serving._told", lambda _, address: seen.append(address)
    )
    done = ops.watch(
        web=True, at=0, port=desk.terminal.name, token_file=tmp_path / "token", timeout=0.5
    )
    token = (tmp_path / "token").read_text().strip()
    assert done["web"] == seen[0] and seen[0].endswith(f"/?token={token}")
    assert seen[1] == serving.text().encode() and done["looks"] == []
