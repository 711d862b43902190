# SPDX-License-Identifier: MIT
"""The page of `pixstep watch --web`, served until somebody ends it."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

from pixstep import signals
from pixstep.board.link import Link
from pixstep.board.port import Port
from pixstep.operations import bus, serve
from pixstep.operations.asked import AskedError
from pixstep.operations.bus import Units
from pixstep.operations.desk import Desk
from pixstep.operations.live.eye import Eye, Spot, names_on, spots_of
from pixstep.operations.live.job_run import LiveRun
from pixstep.operations.live.view import LiveView
from pixstep.server import remote
from pixstep.server.serving import new_token
from pixstep.server.web import Bell, Site
from pixstep.version import __version__

_DATA = Path(__file__).resolve().parents[2] / "data"
_CHARTS = "uplot-1.6.32"


class LivePageAsked(Protocol):
    """What is asked for: where the page is and what it may, and which boards it shows."""

    @property
    def at(self) -> serve.Door:
        """Host and port number of the page."""

    @property
    def token_file(self) -> Path | None:
        """Where its token is."""

    @property
    def allow_stop(self) -> bool:
        """Whether it has a button that stops all boards."""

    @property
    def interval_s(self) -> float:
        """The time from one look to the next."""

    @property
    def port(self) -> str | None:
        """The port of the boards, if it is named."""

    @property
    def bus(self) -> Port:
        """That port, and how it is spoken to."""

    @property
    def units(self) -> Units:
        """The addresses on it."""


@contextlib.contextmanager
def served(desk: Desk, asked: LivePageAsked, run: LiveRun | None) -> Iterator[str]:
    """Yield the address of the page, which is told, and serve it meanwhile."""
    token = serve.token_in(asked.token_file) if asked.token_file else new_token()
    found = _spots(desk, asked, run)
    eyes: list[Eye] = []
    bell = Bell()
    place = run.name if run else ", ".join(spot.port.name for spot in found)
    view = LiveView(eyes, run, place, stops=asked.allow_stop)
    with contextlib.ExitStack() as stack:
        site = Site(asked.at, text(), view, bell, token, view.stop if asked.allow_stop else None)
        stack.callback(site.server_close)
        for spot in found:
            eyes.append(_eye(desk, spot, asked, bell, stack))
        for eye in eyes:
            eye.begin()
            stack.callback(eye.close)
        site.open()
        stack.callback(site.close)
        _told(desk, site.address)
        try:
            yield site.address
        finally:
            with signals.ignored():
                stack.close()


def _told(desk: Desk, address: str) -> None:
    desk.row({"web": address})
    desk.tell(f"{address}   Ctrl-C ends")


def text() -> str:
    """Return the page."""
    filled = {
        "charts_style": _file(f"report/{_CHARTS}.min.css"), "style": _file("live/page.css"),
        "licence": _file("report/uplot-LICENSE.txt").replace("--", "- -"),
        "charts": _file(f"report/{_CHARTS}.min.js"), "script": _file("live/page.js"),
        "version": __version__,
    }  # fmt: skip
    return re.sub(r"\{\{(\w+)\}\}", lambda found: filled[found[1]], _file("live/page.html"))


def _file(name: str) -> str:
    return (_DATA / name).read_text(encoding="utf-8")


def _spots(desk: Desk, asked: LivePageAsked, run: LiveRun | None) -> list[Spot]:
    """Return where the boards are: of the run, of the port, or of the machine file."""
    if run:
        machine = run.job.machine.tables
        names = dict.fromkeys(machine.board_name(machine[name]) for name in run.job.motors)
        return spots_of(machine, asked.port or "", names, served=True)
    if asked.port:
        units = asked.units if isinstance(asked.units, tuple) else ()  # all are looked for
        return [Spot(asked.bus, units, names_on(desk.facts.found, asked.port))]
    if desk.facts.found is None:
        raise AskedError("{port} is missing: no run and no machine file say it")
    machine_file = desk.facts.found
    found = spots_of(machine_file, "", machine_file.boards, served=False)
    if not found:
        raise AskedError("{port} is missing: {path} has none", path=machine_file.path)
    return found


def _eye(
    desk: Desk, spot: Spot, asked: LivePageAsked, bell: Bell, stack: contextlib.ExitStack
) -> Eye:
    """Return what looks at boards; a port that it opens itself is there, or this fails."""
    link: Link | None = None
    if not spot.served:
        link = desk.link or remote.open_bus(spot.port, lambda said: desk.say((said,)))
        if link is not desk.link:
            stack.callback(link.close)
        if not spot.units:
            spot = Spot(spot.port, bus.addresses(desk, link, asked.units), spot.names)
    return Eye(spot, link, asked.interval_s, bell.ring)
