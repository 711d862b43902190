# SPDX-License-Identifier: MIT
"""The passes of the time law over blocks of intervals: tools/native/core/law.h runs them."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from pixstep.lines.core import extension
from pixstep.programs.blends import Floats


@dataclass
class Block:
    """Intervals in a row: |a y - b x| <= most in each bound, x and y at most their caps.

    `a` and `b` have a row of bounds for each interval, `most` a row of motors; `highest` is the x
    that the last pass backwards has found.
    """

    a: Floats
    b: Floats
    most: Floats
    cap: Floats
    end_cap: Floats
    rest: npt.NDArray[np.uint8]
    highest: Floats

    @classmethod
    def of(
        cls, a: Floats, b: Floats, most: Floats, cap: Floats, rest: npt.NDArray[np.bool_]
    ) -> "Block":
        """Return a block whose x is capped by its bounds as well."""
        made = cls(
            np.ascontiguousarray(a), np.ascontiguousarray(b), np.ascontiguousarray(most),
            cap.copy(), cap, rest.astype(np.uint8), np.zeros(len(cap)),
        )  # fmt: skip
        extension().lib.law_caps(made._law()[0], _doubles(made.cap))
        return made

    def __len__(self) -> int:
        return len(self.cap)

    def part(self, choice: slice) -> "Block":
        """Return some of the intervals; both see the same numbers."""
        return Block(
            self.a[choice], self.b[choice], self.most[choice], self.cap[choice],
            self.end_cap[choice], self.rest[choice], self.highest[choice],
        )  # fmt: skip

    def backward(self, end: float) -> float:
        """Find the highest x of the intervals, the last y being at most `end`; return the first."""
        law, kept = self._law()
        first = extension().lib.law_backward(law, end, _doubles(self.highest))
        del kept
        return float(first)

    def forward(self, following: float, w: float, begin: Floats, end: Floats) -> float:
        """Run the intervals from w on and fill in w at both ends of each; return the last."""
        law, kept = self._law()
        last = extension().lib.law_forward(
            law, _doubles(self.highest), following, w, _doubles(begin), _doubles(end)
        )
        del kept
        return float(last)

    def _law(self) -> tuple[Any, list[Any]]:
        """Return the block as the extension takes it, and what must live as long as that."""
        ffi = extension().ffi
        numbers = [_doubles(one) for one in (self.a, self.b, self.most, self.cap, self.end_cap)]
        rest = ffi.from_buffer("uint8_t[]", self.rest)
        law = ffi.new(
            "struct law *",
            (len(self), self.a.shape[1], self.most.shape[1], *numbers, rest),
        )
        return law, [*numbers, rest]


def backward(blocks: list[Block], end: float) -> None:
    """Run the pass backwards over blocks in a row."""
    for block in reversed(blocks):
        end = block.backward(end)


def forward(blocks: list[Block], following: float, w: float) -> tuple[Floats, Floats, float]:
    """Run the pass forwards; `following` is the highest w behind the last block."""
    count = sum(map(len, blocks))
    begin, end = np.empty(count), np.empty(count)
    place = 0
    behind = [*(float(block.highest[0]) for block in blocks[1:]), following]
    for block, next_highest in zip(blocks, behind, strict=True):
        own = slice(place, place + len(block))
        w = block.forward(next_highest, w, begin[own], end[own])
        place += len(block)
    return begin, end, w


def _doubles(values: Floats) -> Any:
    return extension().ffi.from_buffer("double[]", values)
