# SPDX-License-Identifier: MIT
"""Uploads over a bad line; `pixstep-dev robustness uploads` is the long form."""

import random

import pytest

from effort import cases
from pixstep.board.errors import BoardError, ExceptionReplyError
from pixstep.board.upload import LineUpload
from pixstep_dev.robustness import uploads
from pixstep_trials import noise, wire

# What is tried is the serial server, the same code on every board: a third one only takes time.
TWO = ("uno", "mega")
FRAME = wire.seal(bytes(range(60)))
BLOCKS = cases(2000, 10_000)


@pytest.mark.usefixtures("native_board")
def test_every_queue_is_exact():
    outcome = uploads.run(uploads.UploadsPlan(uploads.NATIVE, BLOCKS))
    assert outcome.complaints == []
    assert outcome.blocks >= BLOCKS
    assert outcome.given_up > BLOCKS // 100
    assert len(outcome.noise) == 12
    assert min(outcome.noise.values()) > BLOCKS // 20


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", TWO)
def test_lines_play_exactly(board):
    outcome = uploads.run(uploads.UploadsPlan(board, cases(40, 80)))
    assert outcome.complaints == []
    assert outcome.blocks >= cases(40, 80)
    assert outcome.steps > 5_000


@pytest.mark.usefixtures("native_board")
def test_what_a_careless_upload_does_is_found(monkeypatch):
    """A block that is made anew after its answer was lost doubles entries: the campaign says so."""
    send = LineUpload._send

    def careless(self, entries):
        try:
            return send(self, entries)
        finally:
            self._open = 0

    monkeypatch.setattr(LineUpload, "_send", careless)
    assert uploads.run(uploads.UploadsPlan(uploads.NATIVE, 3000)).complaints


@pytest.mark.parametrize("spoiler", noise.ALWAYS_FOUND)
def test_the_checksum_finds_every_one(spoiler):
    rng = random.Random(1)
    for _ in range(cases(4_000, 20_000)):
        spoilt = spoiler(rng, FRAME)
        assert len(spoilt) == len(FRAME)
        assert spoilt != FRAME
        assert wire.crc16(spoilt) != 0


def test_bytes_are_lost_and_inserted():
    rng = random.Random(1)
    lost = {len(FRAME) - len(noise.lose_bytes(rng, FRAME)) for _ in range(500)}
    inserted = {len(noise.insert_bytes(rng, FRAME)) - len(FRAME) for _ in range(500)}
    assert lost == inserted == {1, 2, 3, 4}
    assert noise.lose_frame(rng, FRAME) == b""


class _Deaf:
    """A board that takes a block and whose answer is lost; then it is as it should be."""

    def __init__(self):
        self.lost, self.blocks, self.free = True, [], 60

    def axis(self, _):
        return {"next_block": 0, "queue_free": self.free, "axis_state": 1, "line_error": 0}

    def packs(self):
        return False

    def write_block(self, _, block, entries):
        self.blocks.append((block, entries))
        if self.lost:
            self.lost, self.free = False, 30
            raise BoardError("no reply")


class _Puzzled(_Deaf):
    """A board that answers with exception 3; whether it has taken the block is another question."""

    def __init__(self, taken, times):
        super().__init__()
        self.taken, self.times, self.due = taken, times, 0

    def axis(self, _):
        return {**super().axis(_), "next_block": self.due}

    def write_block(self, _, block, entries):
        self.blocks.append((block, entries))
        if self.times == 0 or self.taken:
            self.due = block + 1
        if self.times:
            self.times -= 1
            raise ExceptionReplyError(1, "write", 3)


@pytest.mark.parametrize(("taken", "times", "sent"), [(False, 1, 2), (False, 2, 3), (True, 1, 1)])
def test_an_exception_to_a_spoilt_request_is_seen_through(taken, times, sent):
    board = _Puzzled(taken, times)
    assert LineUpload(board, 0, [(5, 1)]).push() == 1
    assert board.blocks == [(0, [(5, 1)])] * sent


def test_an_exception_that_stays_is_told():
    with pytest.raises(ExceptionReplyError):
        LineUpload(_Puzzled(False, 9), 0, [(5, 1)]).push()


def test_a_block_without_an_answer_is_sent_again_as_it_was():
    board = _Deaf()
    entries = [(count, 1) for count in range(1, 101)]
    upload = LineUpload(board, 0, entries)
    with pytest.raises(BoardError):
        upload.push()
    upload.push()
    first, second, third = board.blocks[:3]
    assert first == second == (0, entries[:60])
    assert third == (1, entries[60:90])
