# SPDX-License-Identifier: MIT
"""What a request does to a board, as far as a server must know: who may send it, and when."""

import struct
from dataclasses import dataclass

from pixstep.board import registers as regs
from pixstep.board import rtu

_READS = (
    rtu.READ_COILS, rtu.READ_DISCRETES, rtu.READ_HOLDINGS, rtu.READ_INPUTS, rtu.SERVER_ID, 20,
    rtu.IDENTIFY,
)  # fmt: skip
_DIAGNOSES_THAT_READ = (0, 2, *range(11, 19))
_COIL_ON = 0xFF00
_AXES = 4  # that have coils, and queues
_COMMAND_AT, _BLOCK_AT = 6, 8  # of a PDU: the words of a command; the axis of a block
_ARM, _STOP, _MARK = (regs.COMMANDS[name] for name in ("arm", "stop", "mark"))


ALL = (1 << _AXES) - 1


@dataclass(frozen=True)
class RequestMeaning:
    """What a request does; axes are masks, bit n of axis n."""

    writes: bool = True  # anything; a server gives one client at a time the right to
    stops: int = 0  # axes: it goes before all others
    drives: int = 0  # axes that it arms, or queues a part of a line for
    void_after: int = ALL  # axes: a stop of one of them that comes later makes it void
    marks: bool = False  # boards note its end: nothing may follow for a little


_NOTHING, _WRITES = RequestMeaning(writes=False), RequestMeaning()


def of(pdu: bytes) -> RequestMeaning:
    """Return what a request does; one that is not known counts as one that writes."""
    match pdu[0]:
        case function if function in _READS:
            return _NOTHING
        case rtu.DIAGNOSE:
            return _NOTHING if int.from_bytes(pdu[1:3]) in _DIAGNOSES_THAT_READ else _WRITES
        case rtu.WRITE:
            return _of_write(pdu)
        case rtu.WRITE_COIL if len(pdu) == struct.calcsize(">BHH"):
            coil, value = struct.unpack(">HH", pdu[1:])
            return _of_coil(coil) if value == _COIL_ON else _WRITES
        case _:
            return _WRITES


def _of_write(pdu: bytes) -> RequestMeaning:
    """Return what a write of holding registers does."""
    address = int.from_bytes(pdu[1:3])
    if address == regs.COMMAND_BASE and len(pdu) >= _COMMAND_AT + 4:
        mask, command = struct.unpack_from(">HH", pdu, _COMMAND_AT)
        if command == _STOP:
            return RequestMeaning(stops=mask)
        if command == _ARM:
            return _driving(mask)
        return RequestMeaning(marks=command == _MARK)
    if address == regs.QUEUE_WINDOW and len(pdu) >= _BLOCK_AT + 2:
        axis = int.from_bytes(pdu[_BLOCK_AT : _BLOCK_AT + 2]) & 0xFF
        return _driving(1 << axis & ALL)
    return RequestMeaning(void_after=0) if address < regs.COMMAND_BASE else _WRITES


def _driving(axes: int) -> RequestMeaning:
    return RequestMeaning(drives=axes, void_after=axes)


def _of_coil(coil: int) -> RequestMeaning:
    """Return what it does to switch a coil on."""
    if regs.COIL_ARMED <= coil < regs.COIL_ARMED + _AXES:
        return _driving(1 << coil - regs.COIL_ARMED)
    if regs.COIL_STOP <= coil < regs.COIL_STOP + _AXES:
        return RequestMeaning(stops=1 << coil - regs.COIL_STOP)
    return _WRITES
