# SPDX-License-Identifier: MIT
"""A bad line between a Modbus client and a board: frames are spoilt, lost and repeated.

What a checksum of 16 bits promises, it keeps: every error of 1 to 3 bits in a frame, and every
burst of up to 16 bits, is found. Lost or inserted bytes, and garbage in the place of a frame, pass
it once in 65,536 times; the length that the function asks for must be right as well. `NoiseModel`
says how often each happens.
"""

import random
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

from pixstep.board.modbus import Pipe
from pixstep_trials.wire import FRAME_MAX, FRAME_MIN, crc16

_BURST_BITS = 16
_BYTES = 4  # lost or inserted at once, at most


def flip(rng: random.Random, frame: bytes) -> bytes:
    """Turn over 1 to 3 bits."""
    return _turned(frame, rng.sample(range(8 * len(frame)), rng.randint(1, 3)))


def burst(rng: random.Random, frame: bytes) -> bytes:
    """Turn over the ends of a stretch of 2 to 16 bits, and any of the bits between them."""
    length = rng.randint(2, min(_BURST_BITS, 8 * len(frame)))
    first = rng.randrange(8 * len(frame) - length + 1)
    inner = [bit for bit in range(first + 1, first + length - 1) if rng.random() < 0.5]
    return _turned(frame, [first, *inner, first + length - 1])


def lose_bytes(rng: random.Random, frame: bytes) -> bytes:
    """Leave out 1 to 4 bytes, each anywhere."""
    kept = bytearray(frame)
    for _ in range(min(rng.randint(1, _BYTES), len(frame))):
        del kept[rng.randrange(len(kept))]
    return bytes(kept)


def insert_bytes(rng: random.Random, frame: bytes) -> bytes:
    """Put in 1 to 4 random bytes, each anywhere."""
    kept = bytearray(frame)
    for _ in range(rng.randint(1, _BYTES)):
        kept.insert(rng.randint(0, len(kept)), rng.randrange(256))
    return bytes(kept)


def lose_frame(rng: random.Random, frame: bytes) -> bytes:
    """Nothing arrives."""
    del rng, frame
    return b""


def garbage(rng: random.Random, frame: bytes) -> bytes:
    """Random bytes from some place on, up to as many as there were and a few more."""
    start = rng.randrange(len(frame))
    return frame[:start] + rng.randbytes(rng.randint(1, len(frame) - start + _BYTES))


def _turned(frame: bytes, bits: list[int]) -> bytes:
    turned = bytearray(frame)
    for bit in bits:
        turned[bit // 8] ^= 1 << bit % 8
    return bytes(turned)


ALWAYS_FOUND = (flip, burst)
MOSTLY_FOUND = (lose_bytes, insert_bytes)
Spoiler = Callable[[random.Random, bytes], bytes]


@dataclass(frozen=True)
class NoiseModel:
    """How often a frame (request or reply) suffers, and from what, each as often."""

    share: float = 0.25
    spoilers: tuple[Spoiler, ...] = (*ALWAYS_FOUND, *MOSTLY_FOUND, lose_frame)
    repeated: float = 0.05  # requests that arrive twice, replies that do


class NoisyLine:
    """A bad line in front of a simulated or native board, for `modbus.SimClient`.

    `noise` counts what happened, by name and direction.
    """

    def __init__(self, simulator: Pipe, rng: random.Random, model: NoiseModel) -> None:
        self._simulator, self._rng, self._model = simulator, rng, model
        self.noise: Counter[str] = Counter()
        self.undetected = 0  # spoilt frames whose checksum is right all the same

    def transmit(self, data: bytes, timeout_cycles: int | None = None) -> bytes:
        """Send a frame through the line and return what comes back through it."""
        reply = b""
        for _ in range(self._times("request")):
            arrived = self._through(data, "request")
            if arrived:
                reply += self._simulator.transmit(arrived, timeout_cycles)
        return self._through(reply, "reply") * self._times("reply") if reply else b""

    def cycles(self, seconds: float) -> int:
        """Return a time in the board's cycles."""
        return self._simulator.cycles(seconds)

    def command(self, text: str) -> str:
        """Give a command, which needs no line, and return its answer."""
        return self._simulator.command(text)

    def _times(self, direction: str) -> int:
        """Return how often a frame arrives."""
        if self._rng.random() >= self._model.repeated:
            return 1
        self.noise[f"{direction} repeated"] += 1
        return 2

    def _through(self, frame: bytes, direction: str) -> bytes:
        """Return what arrives of a frame."""
        if self._rng.random() >= self._model.share:
            return frame
        spoiler = self._rng.choice(self._model.spoilers)
        self.noise[f"{direction}: {spoiler.__name__.replace('_', ' ')}"] += 1
        spoilt = spoiler(self._rng, frame)[: 2 * FRAME_MAX]
        if spoilt != frame and len(spoilt) >= FRAME_MIN and crc16(spoilt) == 0:
            self.undetected += 1
        return spoilt
