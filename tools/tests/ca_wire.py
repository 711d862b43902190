# SPDX-License-Identifier: MIT
"""A client of Channel Access on one connection, which notes all that arrives in its order."""

import contextlib
import socket
import time

import caproto as ca

TIMEOUT_S = 10.0
HOST = "127.0.0.1"


class Wire:
    """One connection: `get`, `put`, `monitor`; `seen` is what came, (name, value) each."""

    def __init__(self, port):
        self._socket = socket.create_connection((HOST, port), TIMEOUT_S)
        self.circuit = ca.VirtualCircuit(ca.CLIENT, (HOST, port), 0)
        self._channels = {}
        self._names = {}
        self._puts = {}
        self.seen = []
        self.times_s = []
        self._send(ca.VersionRequest(0, 13), ca.HostNameRequest("test"))
        self._send(ca.ClientNameRequest("test"))

    def close(self):
        """Leave."""
        self._socket.close()

    def channel(self, name):
        """Return a channel, connected."""
        if name not in self._channels:
            found = self._channels[name] = ca.ClientChannel(name, self.circuit)
            self._send(found.create())
            self.until(lambda: found.states[ca.CLIENT] is ca.CONNECTED)
        return self._channels[name]

    def get(self, name, data_type=None):
        """Return the answer of a read."""
        request = self.channel(name).read(data_type=data_type)
        self._send(request)
        return self.until(lambda: self._answer(ca.ReadNotifyResponse, request.ioid))

    def value(self, name):
        """Return the value of a PV."""
        found = self.get(name).data[0]
        return found.decode() if isinstance(found, bytes) else found

    def put(self, name, value, data_type=None):
        """Write, and return the error of the write's end, "" if it is fine."""
        return self.ended(self.begin(name, value, data_type))

    def begin(self, name, value, data_type=None, *, wait=True):
        """Write, and return what `ended` takes; then `seen` has "end"."""
        values = value if isinstance(value, list) else [value]
        request = self.channel(name).write(values, data_type, len(values), notify=wait)
        self._puts[request.ioid] = name
        self._send(request)
        return request.ioid

    def ended(self, ioid):
        """Wait for the end of a write; return its status, "" if it is fine."""
        found = self.until(
            lambda: self._answer(ca.WriteNotifyResponse, ioid) or self._failure(ioid)
        )
        if isinstance(found, ca.ErrorResponse):
            return str(found.error_message)
        return ""

    def monitor(self, *names, data_type=None):
        """Be told of changes; the first values have come when this returns."""
        for name in names:
            request = self.channel(name).subscribe(data_type=data_type)
            self._names[request.subscriptionid] = name
            before = len(self.seen)
            self._send(request)
            self.until(lambda before=before: len(self.seen) > before)

    def until(self, found):
        """Receive until something is found, and return it."""
        end_s = time.monotonic() + TIMEOUT_S
        while not (result := found()):
            left_s = end_s - time.monotonic()
            assert left_s > 0, ("nothing came", self.seen)
            self._socket.settimeout(left_s)
            self._receive()
        return result

    def listen(self, seconds):
        """Receive for some time."""
        end_s = time.monotonic() + seconds
        while (left_s := end_s - time.monotonic()) > 0:
            self._socket.settimeout(left_s)
            with contextlib.suppress(TimeoutError):
                self._receive()

    def saw(self, name):
        """Return the values of a PV in their order."""
        return [value for one, value in self.seen if one == name]

    _answers: list = []

    def _answer(self, kind, ioid):
        return next(
            (one for one in self._answers if isinstance(one, kind) and one.ioid == ioid), None
        )

    def _failure(self, ioid):
        return next(
            (
                one for one in self._answers
                if isinstance(one, ca.ErrorResponse) and one.original_request.parameter2 == ioid
            ),
            None,
        )  # fmt: skip

    def _send(self, *commands):
        self._socket.sendall(b"".join(self.circuit.send(*commands)))

    def _receive(self):
        data = self._socket.recv(65536)
        assert data, "the server closed the connection"
        commands, _ = self.circuit.recv(data)
        for command in commands:
            self.circuit.process_command(command)
            self._note(command)

    def _note(self, command):
        self._answers = [*self._answers, command]
        if isinstance(command, ca.EventAddResponse):
            name = self._names[command.subscriptionid]
            value = command.data[0]
            self.seen.append((name, value.decode() if isinstance(value, bytes) else value))
            self.times_s.append(time.time())
        elif isinstance(command, ca.WriteNotifyResponse):
            self.seen.append(("end", self._puts[command.ioid]))
            self.times_s.append(time.time())
