# SPDX-License-Identifier: MIT
"""Marks on the drawing of a line: its phases, backlash take-up, image start, oscillations."""

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from pixstep.lines import line_check
from pixstep.lines.line import Line
from pixstep.plotting import BOARD, INK
from pixstep.profiles import phases

_PHASE_COLOURS = {
    phases.REST: "#eef1f4",
    phases.UP: "#cfe5ea",
    phases.CONSTANT: "#9cc6d1",
    phases.DOWN: "#cfe5ea",
    phases.SWING: "#e9b9ac",
    phases.TAKE_UP: "#dd8a72",
}
_PALE = "#f7e9e6"  # BOARD at the 12 % of the shading
_DENSE = 240  # phases from which lines between them would run together


def add(panels: tuple[Axes, ...], line: Line, image_pixel: int | None) -> list[Artist]:
    """Shade oscillations and the backlash take-up, mark the image; return the legend's entries."""
    handles: list[Artist] = []
    if line.shifted_pixels:
        end = line.shifted_pixels
        begin = end - line.backlash / line.line_speed
        _shade(panels, [(begin, end - begin)], 0.30)
        text = f"{line.backlash} steps of backlash taken up, px {begin:.6g} to {end}"
        handles.append(Patch(color=BOARD, alpha=0.30, lw=0, label=text))
    if image_pixel is not None:
        at = image_pixel - 1
        for axes in panels:
            axes.axvline(at, color=INK, lw=1, ls=(0, (1, 2)), gid="image")
        text = f"image starts with pixel {image_pixel}"
        handles.append(Line2D([], [], color=INK, lw=1, ls=(0, (1, 2)), label=text))
    return handles + _oscillation_marks(panels, line)


def lane(axes: Axes, line: Line) -> None:
    """Draw the strip that names the parts of the line, where a name fits."""
    axes.set_label("phases")
    axes.set_axis_off()
    axes.set_ylim(0, 1)
    found = phases.of(line)
    for kind, colour in _PHASE_COLOURS.items():
        spans = [(phase.begin, phase.end - phase.begin) for phase in found if phase.kind == kind]
        axes.broken_barh(spans, (0, 1), color=colour, lw=0)
    if len(found) <= _DENSE:
        axes.vlines([phase.begin for phase in found], 0, 1, color="white", lw=1.5)
    for phase in found:
        characters = 118 * (phase.end - phase.begin) / line.pixels
        texts = [text for text in (phase.text, phase.short) if len(text) + 1 <= characters]
        if texts:
            axes.text((phase.begin + phase.end) / 2, 0.46, texts[0], ha="center", va="center",
                      fontsize=8.5, color=INK)  # fmt: skip


def _oscillation_marks(panels: tuple[Axes, ...], line: Line) -> list[Patch]:
    """Shade every oscillating run; name the first five."""
    runs = list(line_check.oscillations(line)) if line.smooth else []
    _shade(panels, [(run.pixel - 1, run.length) for run in runs], 0.12)
    texts = [
        f"pixels {run.pixel} to {run.pixel + run.length - 1} oscillate: {run.count} entered at "
        f"{run.entry_speed}, the speed swings {run.swing[0]} to {run.swing[1]}"
        for run in runs[:5]
    ]
    if len(runs) > 5:
        texts.append(f"and {len(runs) - 5} more oscillating runs")
    return [Patch(facecolor=_PALE, edgecolor=BOARD, lw=0.6, label=text) for text in texts]


def _shade(panels: tuple[Axes, ...], spans: list[tuple[float, float]], alpha: float) -> None:
    """Shade (begin, length) spans over the whole height of the panels."""
    for axes in panels:
        axes.broken_barh(spans, (0, 1), transform=axes.get_xaxis_transform(), color=BOARD,
                         alpha=alpha, lw=0, zorder=0)  # fmt: skip
