# SPDX-License-Identifier: MIT
"""Modbus TCP, the second door of a server: for PLCs, and whatever else speaks it.

The library brings frames and threads; each request goes to the bus as it is, whatever its function.
"""

import itertools
import threading
import time
from dataclasses import replace
from typing import Any

from pixstep.board import rtu
from pixstep.board.port import LAST_UNIT
from pixstep.errors import AskedText, UserError
from pixstep.server import bus, messages
from pixstep.server.bus import BusRequest, BusThread
from pixstep.server.messages import Message, RequestMeaning
from pixstep.server.sessions import ClientSession, Sessions

EXTRA = "pyModbusTCP is not installed: pip install 'pixstep[modbus-tcp]' (in a clone: tools/setup)"
_ILLEGAL_FUNCTION, _BUSY = 1, 6
_NO_PATH, _NO_ANSWER = 10, 11  # of a gateway: the port is gone; the unit does not answer
_EXCEPTIONS = {
    messages.TAKEN: _BUSY,
    messages.OVERTAKEN: _BUSY,
    messages.NO_REPLY: _NO_ANSWER,
}
_ECHO_BYTES = 5  # of the reply to a write: function, address, count or value


class Door:
    """The clients of Modbus TCP: each connection is one, named by its address."""

    def __init__(self, owner: BusThread, sessions: Sessions, *, writes: bool) -> None:
        self._bus, self._sessions, self._writes = owner, sessions, writes
        self._clients: dict[tuple[str, int], ClientSession] = {}
        self._numbers = itertools.count()

    def listen(self, host: str, number: int) -> int:
        """Serve in threads of the library and return the port's number, which is found for 0.

        Raises UserError if that cannot be.
        """
        try:
            from pyModbusTCP.server import ModbusServer
        except ImportError:
            raise UserError(AskedText("{modbus_tcp}: {text}", text=EXTRA)) from None
        door = self

        class PlcServer(ModbusServer):  # type: ignore[misc]
            """The library's server; its clients are the door's."""

            class ModbusService(ModbusServer.ModbusService):  # type: ignore[misc]
                """One connection."""

                def finish(self) -> None:
                    """Let the client go."""
                    door.leave(self.client_address[:2])

        server = PlcServer(host, number, no_block=True, ext_engine=self.answer)
        try:
            server.start()
        except ModbusServer.NetworkError as error:
            raise UserError(AskedText(
                "{modbus_tcp} {place}: {error}", place=f"{host}:{number}", error=_said(error)
            )) from None  # fmt: skip
        found: int = server._service.server_address[1]
        return found

    def answer(self, data: Any) -> None:
        """Answer the library's request of a client."""
        session = self._session((data.client.address, data.client.port))
        session.last_s = time.monotonic()
        session.requests += 1
        data.response.pdu.raw = self._answer(
            session, data.request.mbap.unit_id, data.request.pdu.raw
        )

    def leave(self, address: tuple[str, int]) -> None:
        """Let a client go. Its lines go on: a PLC may connect for each request anew."""
        session = self._clients.pop(address, None)
        if session:
            self._sessions.leave(session)

    def _session(self, address: tuple[str, int]) -> ClientSession:
        session = self._clients.get(address)
        if not session:
            session = ClientSession("{}:{}".format(*address), "modbus tcp")
            self._clients[address] = session
            self._sessions.enter(session)
        return session

    def _answer(self, session: ClientSession, unit: int, pdu: bytes) -> bytes:
        """Return the PDU of the reply."""
        means = messages.meaning_of(pdu)
        if means.writes and not means.stops:
            if not self._writes:
                return _exception(pdu, _ILLEGAL_FUNCTION)
            if self._sessions.claim(session):
                return _exception(pdu, _BUSY)
            self._sessions.drive(session, unit, means)
        tells = unit == 0 and means.writes
        if not (1 <= unit <= LAST_UNIT or tells):
            return _exception(pdu, _NO_ANSWER)
        rank = bus.STOP if means.stops else bus.READER
        answer = self._ask(session, unit, pdu, means, rank, tells=tells)
        if means.stops and answer.get("heard") and "error" in answer:
            # The stop went out at once, and its reply may be another one's. A stop may come twice:
            # the reply to one that waits until the line is clear is surely its own.
            again = replace(means, stops=0, void_after=0)
            answer = self._ask(session, unit, pdu, again, bus.FIRST, tells=False)
        if "error" in answer:
            return _exception(pdu, _EXCEPTIONS.get(answer["error"], _NO_PATH))
        return pdu[:_ECHO_BYTES] if tells else bytes.fromhex(answer["pdu"])

    def _ask(
        self,
        session: ClientSession,
        unit: int,
        pdu: bytes,
        means: RequestMeaning,
        rank: int,
        *,
        tells: bool,
    ) -> Message:
        """Put a request before the bus, and wait for its answer."""
        came = threading.Event()
        answers: list[Message] = []

        def finish(answer: Message) -> None:
            answers.append(answer)
            came.set()

        number = next(self._numbers)
        session.open.add(number)
        patience = self._bus.line.patience
        job = BusRequest(session.name, unit, pdu, means, finish, rank, tells, patience)
        if self._sessions.is_driven(session):
            job.share()
        self._bus.submit(job)
        came.wait()
        session.open.discard(number)
        return answers[0]


def _exception(pdu: bytes, code: int) -> bytes:
    return bytes([pdu[0] | rtu.EXCEPTION, code])


def _said(error: Exception) -> str:
    cause = error.args[0] if error.args else error
    return getattr(cause, "strerror", None) or str(cause)
