# SPDX-License-Identifier: MIT
"""What clients are told: each monitored field when its value differs from what they know."""

from pixstep.motor_record.field import Value
from pixstep.motor_record.fields import FIELDS, MONITOR_ORDER
from pixstep.motor_record.model.values import Values
from pixstep.motor_record.traffic import Post

_NAMES = tuple(FIELDS)
_RANK = {name: rank for rank, name in enumerate(MONITOR_ORDER)}


class MonitorJournal:
    """Compares the values with those last told. RBV has dead bands of its own.

    This is done after every processing, so that it must be quick: what is known has the order of
    the values, and the two are compared in one pass.
    """

    def __init__(self, values: Values) -> None:
        self._values = values
        self._known: dict[str, Value | None] = dict(vars(values))
        self._posts: list[Post] = []

    def post(self, name: str) -> None:
        """Tell the value of a field now, whether or not it changed."""
        value = self._values.read(name)
        self._known[FIELDS[name].attribute] = value
        self._posts.append(Post(name, value))

    def doubt(self, name: str) -> None:
        """Forget what clients know of a field: it is told with the next changes."""
        self._known[FIELDS[name].attribute] = None

    def post_changes(self) -> None:
        """Tell all that changed since the last time, in the order of the record."""
        for name in sorted(filter(_RANK.__contains__, self._changed()), key=_RANK.__getitem__):
            if name != "RBV" or self._worth_telling():
                self.post(name)

    def take(self) -> tuple[Post, ...]:
        """Return what was told since the last time, and forget it."""
        taken, self._posts = tuple(self._posts), []
        return taken

    def _changed(self) -> list[str]:
        pairs = zip(_NAMES, vars(self._values).values(), self._known.values(), strict=True)
        return [name for name, now, known in pairs if now != known]

    def _worth_telling(self) -> bool:
        """True if RBV left one of its dead bands, or has none."""
        v = self._values
        if v.mdel == 0 and v.adel == 0:
            return True
        shown = v.mdel == 0 or abs(v.mlst - v.rbv) > v.mdel
        kept = v.adel == 0 or abs(v.alst - v.rbv) > v.adel
        if shown and v.mdel != 0:
            v.mlst = v.rbv
        if kept and v.adel != 0:
            v.alst = v.rbv
        return shown or kept
