# SPDX-License-Identifier: MIT
"""Fly scans with bluesky: lines that fly on the pixel clock, given as one stream of documents.

`px.fly.LineFlyer` is the flyer, `px.fly.line_from_scanspec` makes its line of a scanspec,
`px.fly.plot` draws what was flown; docs/FLY.md tells how they are used. They need the extra
`pixstep[bluesky]`, drawings `pixstep[plot]`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pixstep.fly.flyer import LineFlyer
    from pixstep.fly.picture import plot
    from pixstep.fly.scan_line import ScanLine
    from pixstep.fly.scanspecs import line_from_scanspec, lines_from_scanspec

__all__ = ["LineFlyer", "ScanLine", "line_from_scanspec", "lines_from_scanspec", "plot"]

_PLACES = {
    "LineFlyer": "flyer",
    "ScanLine": "scan_line",
    "line_from_scanspec": "scanspecs",
    "lines_from_scanspec": "scanspecs",
    "plot": "picture",
}


def __getattr__(name: str) -> Any:
    """Load a name when it is first asked for."""
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_PLACES[name]}"), name)


def __dir__() -> list[str]:
    """Return what the package offers."""
    return sorted(__all__)
