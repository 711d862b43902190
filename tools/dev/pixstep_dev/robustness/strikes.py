# SPDX-License-Identifier: MIT
"""Mutated and foreign frames, reproducible from a seed: what a bad bus does to a board.

A strike is a row of pieces with a pause behind each. Nothing in it can touch the motion: every
beginning of what the board may take for a frame is looked at (`wire.Safety`), and a strike in
which one could be obeyed is made anew.
"""

import random
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from pixstep.board import registers as regs
from pixstep_trials import wire

_SILENCE_US = 1750


@dataclass(frozen=True)
class Pauses:
    """Pauses on the line in cycles of the board."""

    silence: int  # ends a frame
    short: int  # inside a frame: never taken for its end
    wait: int  # mostly taken for its end, not when the board is busy
    certain: int  # always taken for its end
    answer: int  # a reply has begun, if one comes

    @classmethod
    def at(cls, tick_hz: int) -> "Pauses":
        """Return the pauses for a board with so many cycles a second."""
        silence = tick_hz * _SILENCE_US // 1_000_000
        return cls(silence, silence * 2 // 5, silence * 3 // 2, 4 * silence, tick_hz // 40)


@dataclass(frozen=True)
class Strike:
    """Pieces (bytes, pause in cycles) of one kind of mischief.

    `request` is the request that must be answered, empty if none need be; `silent` says that
    nothing may be answered.
    """

    kind: str
    pieces: tuple[tuple[bytes, int], ...]
    request: bytes = b""
    silent: bool = False


class Generator:
    """Makes strikes for one board on a line with others."""

    def __init__(self, rng: random.Random, unit: int, safety: wire.Safety, pauses: Pauses) -> None:
        self._rng, self._unit, self._safety, self.pauses = rng, unit, safety, pauses
        self._others = tuple(address for address in range(1, 248) if address != unit)
        self._makers: tuple[Callable[[], Strike], ...] = (
            self._random_bytes,
            self._truncated,
            self._bad_checksum,
            self._flipped,
            self._over_long,
            self._wrong_count,
            self._foreign_reply,
            self._foreign_run_on,
            self._broadcast_read,
            self._any_function,
            self._valid_read,
            self._refused_write,
            self._with_gap,
            self._split,
            self._run_together,
        )
        self._before = b""  # bytes since the line was certainly silent
        self._starts = [0]  # places in it where a frame may begin

    def __iter__(self) -> Iterator[Strike]:
        """Yield strikes for ever, each kind as often."""
        while True:
            for make in self._rng.sample(self._makers, len(self._makers)):
                yield self._harmless(make)

    def silence(self) -> None:
        """The line was certainly silent, or a reply came: what was sent before is forgotten."""
        self._before, self._starts = b"", [0]

    def _harmless(self, make: Callable[[], Strike]) -> Strike:
        """Make strikes until one is harmless after what was sent before.

        A strike that may be answered ends with a pause that is long enough for that: who sends
        into a reply learns nothing.
        """
        while True:
            strike = make()
            frames = self._frames(strike)
            if not all(self._safety.harmless(frame) for frame in frames):
                continue
            if any(frame[0] == self._unit for frame in frames):
                piece, pause = strike.pieces[-1]
                pieces = (*strike.pieces[:-1], (piece, max(pause, self.pauses.answer)))
                strike = replace(strike, pieces=pieces)
            self._before, self._starts = self._after(strike)
            return strike

    def _frames(self, strike: Strike) -> list[bytes]:
        """Return all that the board may take for a frame, to it or to all.

        One may begin behind a silence and behind any other that is whole, another board's too.
        """
        found: list[bytes] = []
        for seen, starts in self._stages(strike):
            left, known = list(starts), set(starts)
            while left:
                start = left.pop()
                for frame in wire.frames_in(seen[start:]):
                    if frame[0] in (0, self._unit):
                        found.append(frame)
                    if start + len(frame) not in known:
                        known.add(start + len(frame))
                        left.append(start + len(frame))
        return found

    def _stages(self, strike: Strike) -> Iterator[tuple[bytes, list[int]]]:
        """Yield what has been sent behind each piece, and where in it a frame may begin."""
        seen, starts = self._before, list(self._starts)
        for piece, pause in strike.pieces:
            seen += piece
            yield seen, starts
            if pause >= self.pauses.certain:
                seen, starts = b"", [0]
            elif pause >= self.pauses.silence:
                starts = [*starts, len(seen)]
        yield seen, starts

    def _after(self, strike: Strike) -> tuple[bytes, list[int]]:
        """Return what is still of meaning when the strike is over."""
        *_, last = self._stages(strike)
        return last

    # Parts of strikes.

    def _bytes(self, low: int, high: int) -> bytes:
        return self._rng.randbytes(self._rng.randint(low, high))

    def _words(self, *words: int) -> bytes:
        return struct.pack(f">{len(words)}H", *(word & 0xFFFF for word in words))

    def _read_body(self, unit: int) -> bytes:
        """Return a read that the board serves: any range of what every board has."""
        first, most = self._rng.choice(((0x0000, 0x1F), (0x0020, 16), (0x0060, 8)))
        start = first + self._rng.randrange(most)
        count = self._rng.randint(1, first + most - start)
        return bytes([unit, 4]) + self._words(start, count)

    def _write_body(self, unit: int) -> bytes:
        """Return a write that would be obeyed: commands, settings, blocks, coils."""
        rng = self._rng
        kind = rng.randrange(5)
        if kind == 0:  # arm, disarm, stop, clear, discard, ...
            words = self._words(rng.randint(1, 15), rng.randint(1, 10))
            return bytes([unit, 16]) + self._words(regs.COMMAND_BASE, 2) + bytes([4]) + words
        if kind == 1:
            return bytes([unit, 6]) + self._words(
                rng.randrange(wire.SETTINGS_END), rng.randrange(200)
            )
        if kind == 2:
            count = 2 * rng.randint(1, 20)
            head = self._words(regs.QUEUE_WINDOW, count + 2) + bytes([2 * count + 4])
            block = self._words(rng.randrange(0x10000), rng.randrange(4))
            return bytes([unit, 16]) + head + block + self._bytes(2 * count, 2 * count)
        if kind == 3:
            return bytes([unit, 5]) + self._words(rng.randrange(14), rng.choice((0, 0xFF00)))
        return bytes([unit, 22]) + self._words(
            rng.randrange(wire.SETTINGS_END), *rng.choices(range(99), k=2)
        )

    def _any_body(self) -> bytes:
        make = self._rng.choice((self._read_body, self._write_body))
        return make(self._unit)

    def _one(self, kind: str, data: bytes, **facts: Any) -> Strike:
        pause = self.pauses.certain if self._rng.random() < 0.1 else self.pauses.wait
        return Strike(kind, ((data, pause),), **facts)

    def _asked(self, kind: str, *before: tuple[bytes, int]) -> Strike:
        """Return a strike that ends with a request that must be answered."""
        request = wire.seal(self._read_body(self._unit))
        return Strike(kind, (*before, (request, self.pauses.answer)), request=request)

    # Kinds of strikes.

    def _random_bytes(self) -> Strike:
        head = self._rng.choice((b"", bytes([self._unit]), bytes([0])))
        return self._one("random bytes", head + self._bytes(1, 40))

    def _truncated(self) -> Strike:
        frame = wire.seal(self._any_body())
        return self._one("truncated", frame[: self._rng.randrange(1, len(frame))])

    def _bad_checksum(self) -> Strike:
        frame = wire.seal(self._any_body())
        crc = bytes(byte ^ self._rng.randint(1, 255) for byte in frame[-2:])
        return self._one("wrong checksum", frame[:-2] + crc, silent=True)

    def _flipped(self) -> Strike:
        frame = bytearray(wire.seal(self._any_body()))
        for bit in self._rng.sample(range(8 * len(frame)), self._rng.randint(1, 3)):
            frame[bit // 8] ^= 1 << bit % 8
        return self._one("bits turned over", bytes(frame))

    def _over_long(self) -> Strike:
        extra = self._rng.choice((1, 2, 10, 257))
        body = self._any_body() + self._bytes(extra, extra)
        return self._one("over-long", wire.seal(body))

    def _wrong_count(self) -> Strike:
        rng = self._rng
        count, size = rng.randint(0, 130), rng.randint(0, 40)
        function = rng.choice((15, 16, 23))
        head = bytes([self._unit, function])
        if function == 23:
            head += self._words(0, rng.randint(0, 130))
        head += self._words(regs.COMMAND_BASE, count)
        body = head + bytes([size]) + self._bytes(0, 40)
        return self._one("wrong byte count", wire.seal(body))

    def _reply_of_other(self) -> bytes:
        other = self._rng.choice(self._others)
        count = self._rng.randint(1, 30)
        return wire.seal(
            bytes([other, self._rng.choice((3, 4)), 2 * count]) + self._bytes(2 * count, 2 * count)
        )

    def _foreign_reply(self) -> Strike:
        return self._asked(
            "another's reply, then a request", (self._reply_of_other(), self.pauses.certain)
        )

    def _foreign_run_on(self) -> Strike:
        data = self._reply_of_other() + wire.seal(self._any_body())
        return self._one("another's reply run into a request", data)

    def _broadcast_read(self) -> Strike:
        body = bytes([0, self._rng.choice((1, 2, 3, 4, 17, 23))]) + self._words(0, 2)
        return self._one("broadcast read", wire.seal(body), silent=True)

    def _any_function(self) -> Strike:
        function = self._rng.randrange(256)
        body = bytes([self._unit, function]) + self._bytes(0, 12)
        return self._one("any function", wire.seal(body))

    def _valid_read(self) -> Strike:
        return self._asked("valid read", (b"", self.pauses.certain))

    def _refused_write(self) -> Strike:
        rng = self._rng
        if rng.random() < 0.5:
            body = bytes([self._unit, 6]) + self._words(
                rng.randrange(wire.SETTINGS_END), rng.randrange(200)
            )
        else:
            words = self._words(*rng.choices(range(0x10000), k=4))
            where = rng.choice((0x0002, 0x0030, 0x0100, 0x00FF, 0x2000, 0xFFFE))
            body = bytes([self._unit, 16]) + self._words(where, 4) + bytes([8]) + words
        request = wire.seal(body)
        return Strike(
            "refused write",
            ((b"", self.pauses.certain), (request, self.pauses.answer)),
            request=request,
        )

    def _with_gap(self) -> Strike:
        request = wire.seal(self._read_body(self._unit))
        cut = self._rng.randrange(1, len(request))
        pieces = (
            (b"", self.pauses.certain),
            (request[:cut], self.pauses.short),
            (request[cut:], self.pauses.answer),
        )
        return Strike("short gap in a request", pieces, request=request)

    def _split(self) -> Strike:
        frame = wire.seal(self._any_body())
        cut = self._rng.randrange(1, len(frame))
        return Strike(
            "silence in a request",
            (
                (frame[:cut], self.pauses.certain),
                (frame[cut:], self.pauses.wait),
            ),
        )

    def _run_together(self) -> Strike:
        frames = [wire.seal(self._read_body(self._unit)) for _ in range(self._rng.randint(2, 4))]
        return self._one("requests without silence", b"".join(frames))
