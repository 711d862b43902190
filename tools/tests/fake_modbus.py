# SPDX-License-Identifier: MIT
"""The Modbus server of a fake board: frames to reads and writes, by the standard."""

import struct

from pixstep_trials.wire import seal

ILLEGAL, ADDRESS, VALUE, FAILURE, BUSY = 1, 2, 3, 4, 6


# The feature that a function belongs to; the others are always served.
SERVED_BY = dict.fromkeys((1, 2, 5, 15), "bits") | dict.fromkeys((8, 17, 22, 23, 43), "diagnosis")


class RefusalError(Exception):
    """A Modbus exception; its argument is the code."""


class FakeServer:
    """Answers frames; the board behind it has `read`, `write`, `read_bits`, `write_coils` and
    `has`, which says whether it was built with a feature.
    """

    def answer(self, unit, pdu):
        """Return the reply frame, None for another's request or a broadcast."""
        self.tick()
        mine = self.holdings[0]
        if unit not in (0, mine):
            return None
        try:
            reply = self.serve(pdu[0], pdu[1:])
        except RefusalError as refused:
            reply = bytes([pdu[0] | 0x80, refused.args[0]])
        if unit == 0:
            return None
        frame = bytes([mine]) + reply
        return seal(frame)

    def serve(self, function, data):
        if function in (3, 4):
            first, count = struct.unpack(">HH", data)
            words = self.read(function == 4, first, count)
            return struct.pack(f">BB{count}H", function, 2 * count, *words)
        if function in SERVED_BY and not self.has(SERVED_BY[function]):
            raise RefusalError(ILLEGAL)
        if function in (1, 2):
            first, count = struct.unpack(">HH", data)
            bits = self.read_bits(function == 1, first, count)
            packed = sum(bit << index for index, bit in enumerate(bits))
            size = (count + 7) // 8
            return bytes([function, size]) + packed.to_bytes(size, "little")
        handler = getattr(self, f"do_{function}", None)
        if handler is None:
            raise RefusalError(ILLEGAL)
        return handler(bytes([function]), data)

    def do_5(self, head, data):
        address, value = struct.unpack(">HH", data)
        self.write_coils(address, [value == 0xFF00])
        return head + data

    def do_6(self, head, data):
        address, word = struct.unpack(">HH", data)
        self.write(address, [word])
        return head + data

    def do_8(self, head, data):
        sub, _word = struct.unpack(">HH", data)
        if sub in self.counters:
            return head + struct.pack(">HH", sub, self.counters[sub])
        if sub == 10:
            self.counters = dict.fromkeys(self.counters, 0)
        elif sub not in (0, 1, 4):
            raise RefusalError(ILLEGAL)
        return head + data

    def do_15(self, head, data):
        first, count, _size = struct.unpack(">HHB", data[:5])
        packed = int.from_bytes(data[5:], "little")
        self.write_coils(first, [bool(packed >> index & 1) for index in range(count)])
        return head + data[:4]

    def do_16(self, head, data):
        first, count, size = struct.unpack(">HHB", data[:5])
        if size != 2 * count:
            raise RefusalError(VALUE)
        self.write(first, list(struct.unpack(f">{count}H", data[5:])))
        return head + data[:4]

    def do_17(self, head, _data):
        text = f"pixstep {self.kind} 0.1".encode()
        running = any(axis.state == "running" for axis in self.axes)
        return head + bytes([len(text) + 2, self.id, 0xFF if running else 0]) + text

    def do_22(self, head, data):
        address, keep, put = struct.unpack(">HHH", data)
        (old,) = self.read(False, address, 1)
        self.write(address, [old & keep | put & ~keep & 0xFFFF])
        return head + data

    def do_23(self, head, data):
        first, count, at, _words, _size = struct.unpack(">HHHHB", data[:9])
        self.write(at, list(struct.unpack(f">{len(data[9:]) // 2}H", data[9:])))
        return head + struct.pack(f">B{count}H", 2 * count, *self.read(False, first, count))

    def do_43(self, head, data):
        kind, code, _first = data
        assert kind == 14
        objects = (b"pixstep", self.kind.encode(), b"0.1", b"", b"motor board")
        objects = objects[: 3 if code == 1 else 5]
        body = b"".join(bytes([n, len(text)]) + text for n, text in enumerate(objects))
        return head + bytes([14, code, 0x82, 0, 0, len(objects)]) + body
