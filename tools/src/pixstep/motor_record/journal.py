# SPDX-License-Identifier: MIT
"""What clients are told: each monitored field when its value differs from what they know."""

from pixstep.motor_record.field import Value
from pixstep.motor_record.fields import FIELDS, MONITOR_ORDER
from pixstep.motor_record.traffic import Post
from pixstep.motor_record.values import Values

_ORDER = tuple((name, FIELDS[name].attribute) for name in MONITOR_ORDER)


class Journal:
    """Compares the values with those last posted. RBV has dead bands of its own."""

    def __init__(self, values: Values) -> None:
        self._values = values
        self._known: dict[str, Value] = dict(vars(values))
        self._posts: list[Post] = []

    def post(self, name: str) -> None:
        """Tell the value of a field now, whether or not it changed."""
        value = self._values.read(name)
        self._known[FIELDS[name].attribute] = value
        self._posts.append(Post(name, value))

    def doubt(self, name: str) -> None:
        """Forget what clients know of a field: it is told with the next changes."""
        del self._known[FIELDS[name].attribute]

    def post_changes(self) -> None:
        """Tell all that changed since the last time, in the order of the record."""
        now, known = vars(self._values), self._known
        changed = [name for name, attribute in _ORDER if now[attribute] != known.get(attribute)]
        for name in changed:
            if name != "RBV" or self._worth_telling():
                self.post(name)

    def take(self) -> tuple[Post, ...]:
        """Return what was told since the last time, and forget it."""
        taken, self._posts = tuple(self._posts), []
        return taken

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
