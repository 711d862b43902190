# SPDX-License-Identifier: MIT
"""The client of a bus in the server's own process: for what the server itself asks of boards."""

import threading
from collections.abc import Callable

from pixstep.board.modbus import (
    Client,
    LineGoneError,
    RequestError,
    WriteTimeoutError,
)
from pixstep.board.rtu import Reply
from pixstep.errors import UserError
from pixstep.server import bus, messages
from pixstep.server.bus import BusRequest, BusThread
from pixstep.server.messages import Message


class LocalModbus(Client):
    """What the server asks goes before what its clients ask."""

    def __init__(self, owner: BusThread, name: str = "the server", rank: int = bus.FIRST) -> None:
        super().__init__(*owner.line.patience)
        self._bus, self._name, self._rank = owner, name, rank
        self.place = owner.line.place

    def ask(self, unit: int, pdu: bytes, *, urgent: bool = False) -> Reply:
        """Send a request and return its reply."""
        del urgent  # the request says so itself
        answer = self.answer(unit, pdu)
        self.heard = answer.get("heard", 0)
        raise_error(answer)
        return Reply(bytes.fromhex(answer["pdu"]), 0)

    def tell(self, pdu: bytes, unit: int = 0) -> None:
        """Send a request to which nobody replies."""
        raise_error(self.answer(unit, pdu, tells=True))

    def answer(self, unit: int, pdu: bytes, *, tells: bool = False) -> Message:
        """Send a request and return its answer, as clients get it."""
        came = threading.Event()
        answers: list[Message] = []

        def finish(answer: Message) -> None:
            answers.append(answer)
            came.set()

        means = messages.meaning_of(pdu)
        rank = bus.STOP if means.stops else self._rank
        self._bus.submit(
            BusRequest(self._name, unit, pdu, means, finish, rank, tells, patience=self.patience)
        )
        came.wait()
        return answers[0]


_RAISED: dict[str, Callable[[], Exception]] = {
    messages.NO_REPLY: RequestError,
    messages.LINE_GONE: LineGoneError,
    messages.WRITE_TIMEOUT: WriteTimeoutError,
}


def raise_error(answer: Message) -> None:
    """Raise what is wrong in an answer, as a client of a serial port would."""
    kind = answer.get("error")
    if kind in _RAISED:
        raise _RAISED[kind]()
    if kind:
        raise UserError(str(answer.get("text", kind)))
