# SPDX-License-Identifier: MIT
"""The report of a run as one HTML file: text and tables by themselves, drawings by its script.

The file asks no network for anything, and its own policy forbids that it does.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator
from html import escape
from pathlib import Path
from typing import Any

from pixstep.jobs.report import pixels
from pixstep.jobs.report.pixels import ReportFigures
from pixstep.jobs.report.story import AMBER, BLUE, GREEN, RED, Story, duration_text
from pixstep.jobs.run_log import Event
from pixstep.version import __version__

_DATA = Path(__file__).resolve().parents[2] / "data" / "report"
_CHARTS = "uplot-1.6.32"
_RELOAD_S = 5
KEY_MARK = "\N{BLACK DIAMOND}"
_WORDS = {"green": "equal", "grey": "differs, changes nothing", "amber": "differs, somebody agreed",
          "red": "differs, must not be printed"}  # fmt: skip


def text(story: Story, figures: ReportFigures, name: str) -> str:
    """Return the page of a run of some name."""
    verdict, notes = story.verdict[1], [*_notes(story, figures)]
    listed, data = figures.packed()
    filled = {
        "verdict": escape(verdict), "colour": colour(story, figures), "name": escape(name),
        "charts_style": _file(f"{_CHARTS}.min.css"), "style": _file("page.css"),
        "licence": _file("uplot-LICENSE.txt").replace("--", "- -"),
        "notes": "".join(f'<li class="{tone}">{escape(said)}</li>' for tone, said in notes),
        "cards": "".join(_card(*one) for one in _cards(story, figures)),
        "comparison": _comparison(story.comparison),
        "events": "".join(_row(_cells(one)) for one in story.happened()),
        "motors": ", ".join(map(escape, story.job.motors)),
        "job": escape(story.job.header.id), "version": __version__,
        "about": _json(_about(story, listed)), "data": data,
        "charts": _file(f"{_CHARTS}.min.js"), "script": _file("page.js"),
    }  # fmt: skip
    return re.sub(r"\{\{(\w+)\}\}", lambda found: filled[found[1]], _file("page.html"))


def colour(story: Story, figures: ReportFigures) -> str:
    """Return the colour of a report: the worst of its verdict and its notes."""
    found = [story.verdict[0], *(tone for tone, _ in _notes(story, figures))]
    return next(one for one in (RED, AMBER, BLUE, GREEN) if one in found)


def _file(name: str) -> str:
    return (_DATA / name).read_text(encoding="utf-8")


def _json(value: object) -> str:
    return json.dumps(value, separators=(",", ":")).replace("<", "\\u003c")


def _notes(story: Story, figures: ReportFigures) -> Iterator[tuple[str, str]]:
    """Yield what else a reader must know, the colour of each first."""
    if figures.strange:
        yield RED, f"boards expected other positions than the job has, in {figures.strange} records"
    if figures.worst_off:
        steps = f"{abs(figures.worst_off)} step{'s' * (abs(figures.worst_off) != 1)}"
        yield AMBER, f"a motor was up to {steps} from where it should be: {figures.off_at}"
    if story.state not in ("running", "finished") and story.told.in_flight:
        lines = ", ".join(map(str, story.told.in_flight))
        yield AMBER, f"in flight when the log ended, asked about at resume: line {lines}"
    compared = story.comparison
    if compared.get("comparison") == "amber":
        who = compared.get("accepted_by", "somebody")
        yield AMBER, f"the machine differed from the job's copy; {who} agreed"
    if not figures.records:
        yield "grey", "no per-pixel records: run with --records, and pixels have figures here"


def _cards(story: Story, figures: ReportFigures) -> Iterator[tuple[str, str, str]]:
    """Yield the figures at the top: a name, a figure, a word beside it."""
    yield "lines printed", f"{story.printed}", f"of {story.job.lines}"
    yield "motors", f"{len(story.job.motors)}", f"{story.job.pixels} pixels a line"
    chains = story.chains
    gaps = "no gap between lines" if chains == 1 else "lines began again from rest"
    yield "begun from rest", f"{chains} time{'s' * (chains != 1)}", gaps if chains else "not yet"
    yield "time", duration_text(story.seconds), f"{float(story.job.pixel_hz):g} pixels a second"
    if figures.records:
        yield "largest edge error", f"{figures.worst_error}", "ticks"
        yield "furthest off", f"{abs(figures.worst_off)}", f"steps, {figures.records} records"


def _card(name: str, figure: str, beside: str) -> str:
    return (
        f"<div><dt>{escape(name)}</dt><dd><b>{escape(figure)}</b> "
        f"<span>{escape(beside)}</span></dd></div>"
    )


def _comparison(event: Event) -> str:
    """Return the comparison with its legend: what differs, and key fields that are equal."""
    if "fields" not in event:
        return "<p>The log has no comparison.</p>"
    verdict = event["comparison"]
    differing = [one for one in event["fields"] if one["colour"] != "green"]
    equal = [one for one in event["fields"] if one["colour"] == "green"]
    count = sum(one["colour"] != "grey" for one in differing)
    said = f"{count} difference{'s' * (count != 1)} to agree to" if count else "as the job has it"
    legend = "".join(
        f'<li><i class="dot {name}"></i><b>{name}</b> {words}</li>'
        for name, words in _WORDS.items()
    )
    keys = f"{len(equal)} key fields are equal, and {event.get('equal', 0)} fields more"
    return (
        f'<p class="said"><i class="dot {verdict}"></i><b>{verdict}</b>: {said}</p>'
        f"{_fields(differing) if differing else ''}"
        f"<details><summary>{keys}</summary>{_fields(equal)}</details>"
        f'<ul class="legend">{legend}<li><b>{KEY_MARK}</b> key field: it decided the counts of the '
        f"lines</li></ul>"
    )


def _fields(found: list[Event]) -> str:
    head = "".join(
        f'<th scope="col">{one}</th>' for one in ("", "field", "in the job", "found", "", "why")
    )
    return (
        f'<div class="wide"><table class="fields"><thead><tr>{head}</tr></thead>'
        f"<tbody>{''.join(map(_field, found))}</tbody></table></div>"
    )


def _field(one: Event) -> str:
    name = one["field"] if one["place"].endswith(".toml") else f"{one['place']}: {one['field']}"
    mark = KEY_MARK if one["key"] else ""
    cells = [mark, name, one["job"], one["found"]]
    tone = one["colour"]
    row = f'<tr class="{tone}{" key" if one["key"] else ""}">' + _cells(cells)
    return f'{row}<td><i class="dot {tone}"></i>{tone}</td>{_cells([one["why"]])}</tr>'


def _cells(texts: Iterable[str]) -> str:
    return "".join(f"<td>{escape(one)}</td>" for one in texts)


def _row(cells: str) -> str:
    return f"<tr>{cells}</tr>"


def _about(story: Story, listed: list[dict[str, Any]]) -> dict[str, Any]:
    """Return what the script has to know besides the arrays."""
    job = story.job
    motors = []
    for name, about in job.header.motors.items():
        scale = job.machine.tables[name].steps_per_unit
        motors.append({
            "name": name, "kind": about.decode, "role": about.role,
            "unit": scale.length if scale else "steps",
            "scale": float(scale.steps_per_unit) if scale else 1,
        })  # fmt: skip
    return {
        "lines": job.lines, "pixels": job.pixels, "image": job.header.line.image_pixels,
        "hz": float(job.pixel_hz), "motors": motors, "fates": story.fates,
        "reload_s": _RELOAD_S if story.state == "running" else 0,
        "missing": pixels.MISSING, "arrays": listed,
    }  # fmt: skip
