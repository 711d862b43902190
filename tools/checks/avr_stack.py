# SPDX-License-Identifier: MIT
"""The functions of an AVR image, who may reach whom, and how much stack that takes.

What cannot be bounded is refused with an ImageError: recursion, pushes in a loop, a stack pointer
set to something computed.
"""

import re
from dataclasses import dataclass, field
from itertools import pairwise


class ImageError(Exception):
    """The image cannot be judged; the message says why."""


@dataclass
class Function:
    """One function: its own stack use in bytes and where control may go from it."""

    name: str
    pushes: int = 0
    frame: int = 0
    calls: set[str] = field(default_factory=set)
    jumps: set[str] = field(default_factory=set)
    indirect: bool = False
    opens_interrupts: bool = False
    step_registers: bool = False  # names one of the step interrupt's own
    unbounded: str = ""  # why its stack cannot be counted
    moves: list[tuple[int, int]] = field(default_factory=list)  # address, bytes pushed less popped
    loops: list[tuple[int, int]] = field(default_factory=list)  # first and last address

    def left_on_stack(self, first: int = 0, last: int = 1 << 32) -> int:
        """Bytes pushed less those popped between two addresses."""
        return sum(taken for address, taken in self.moves if first <= address <= last)

    def pushes_in_loop(self) -> bool:
        """Whether some loop leaves more on the stack each time round."""
        return any(self.left_on_stack(first, last) > 0 for first, last in self.loops)


@dataclass
class Image:
    """All functions of an ELF file. `return_bytes` is what a call puts on the stack."""

    functions: dict[str, Function]
    typed: set[str]
    return_bytes: int

    def reachable(self, start: str) -> set[str]:
        """Names of all functions that control may reach from one, itself included."""
        seen: set[str] = set()
        waiting = [start]
        while waiting:
            name = waiting.pop()
            if name not in seen and name in self.functions:
                seen.add(name)
                waiting += self.functions[name].calls | self.functions[name].jumps
        return seen

    def handlers(self) -> list[str]:
        """Interrupt handlers, by their vectors' names."""
        return sorted(name for name in self.functions if re.fullmatch(r"__vector_\d+", name))

    def deepest(self, start: str, trail: tuple[str, ...] = ()) -> tuple[int, list[str]]:
        """Worst stack bytes from a function's entry on, and the path that takes them."""
        function = self.functions[start]
        if function.unbounded or function.pushes_in_loop():
            raise ImageError(f"{start}: {function.unbounded or 'pushes in a loop'}")
        own = function.pushes + function.frame
        worst, path = own, []
        inside = (*trail, start)
        for callee in sorted(function.calls & self.functions.keys()):
            if callee in inside:
                raise ImageError("recursion: " + " -> ".join([*inside, callee]))
            below, below_path = self.deepest(callee, inside)
            if own + self.return_bytes + below > worst:
                worst, path = own + self.return_bytes + below, below_path
        for label in sorted(function.jumps & self.functions.keys()):
            if label in inside:
                self.refuse_growing_circle([*inside[inside.index(label) :], label])
                continue
            below, below_path = self.deepest(label, inside)
            kept = self.kept_at_jump(start, label)
            if kept + below > worst:
                worst, path = kept + below, below_path
        return worst, [start, *path]

    def kept_at_jump(self, start: str, label: str) -> int:
        """Bytes that stay on the stack at a jump out of a function.

        Before it jumps to a function, a compiler gives its own frame back; a jump to a label of
        hand-written assembly keeps it.
        """
        function = self.functions[start]
        return 0 if label in self.typed else function.pushes + function.frame

    def refuse_growing_circle(self, circle: list[str]) -> None:
        """Raise ImageError if going round a circle leaves something on the stack each time."""
        if any(label in self.functions[one].calls for one, label in pairwise(circle)):
            raise ImageError("recursion: " + " -> ".join(circle))
        left = sum(
            self.functions[one].left_on_stack()
            for one, label in pairwise(circle)
            if label not in self.typed
        )
        if left > 0:
            raise ImageError("a circle of jumps that pushes: " + " -> ".join(circle))
