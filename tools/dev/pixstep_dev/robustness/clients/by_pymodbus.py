# SPDX-License-Identifier: MIT
"""The conformance list by pymodbus' own serial client, on a pseudo terminal."""

import struct
from typing import Any

from pymodbus.client import ModbusSerialClient
from pymodbus.pdu import ModbusPDU
from pymodbus.pdu.file_message import FileRecord

from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep_dev.robustness.clients import cases
from pixstep_dev.robustness.clients.cases import AnsweredError, ConformanceError, same

_TIMEOUT_S = 30.0


class _Raw(ModbusPDU):
    """A request that pymodbus itself would refuse to make."""

    def __init__(self, function: int, body: bytes) -> None:
        super().__init__(dev_id=cases.UNIT)
        self.function_code, self._body = function, body

    def encode(self) -> bytes:
        """Return the bytes behind the function code."""
        return self._body


def run(port: str, board: str) -> dict[str, str]:
    """Return the result of every case."""
    client = ModbusSerialClient(port, baudrate=115_200, parity="N", timeout=_TIMEOUT_S, retries=1)
    if not client.connect():
        raise ConformanceError(f"{port}: cannot be opened")
    try:
        checks = _PymodbusCases(client, board)
        return cases.run_list(checks, boards.feature_names(checks.inputs(cases.FEATURES)[0]))
    finally:
        client.close()  # type: ignore[no-untyped-call]


class _PymodbusCases:
    """A method for every case."""

    def __init__(self, client: ModbusSerialClient, board: str) -> None:
        self.client, self.board = client, board
        self.unit: dict[str, Any] = {"device_id": cases.UNIT}

    # What most of them need.

    def good(self, reply: ModbusPDU) -> Any:
        """Return a reply that must not be an exception."""
        if reply.isError():
            raise AnsweredError(reply.exception_code)
        return reply

    def refused(self, reply: ModbusPDU, code: int) -> None:
        """The reply must be this exception."""
        if not reply.isError():
            raise ConformanceError("no exception")
        if reply.exception_code != code:
            raise AnsweredError(reply.exception_code, f"{reply.exception_code}, not {code}")

    def raw(self, function: int, *words: int, data: bytes = b"") -> ModbusPDU:
        """Send a request made by hand."""
        body = struct.pack(f">{len(words)}H", *words) + data
        return self.client.execute(False, _Raw(function, body))

    def inputs(self, address: int, count: int = 1) -> list[int]:
        """Read input registers."""
        reply = self.client.read_input_registers(address, count=count, **self.unit)
        return list(self.good(reply).registers)

    def holdings(self, address: int, count: int = 1) -> list[int]:
        """Read holding registers."""
        reply = self.client.read_holding_registers(address, count=count, **self.unit)
        return list(self.good(reply).registers)

    def write(self, address: int, *words: int) -> ModbusPDU:
        """Write holding registers."""
        return self.client.write_registers(address, list(words), **self.unit)

    def coils(self, address: int, count: int = 1) -> list[bool]:
        """Read coils."""
        reply = self.client.read_coils(address, count=count, **self.unit)
        return list(self.good(reply).bits[:count])

    def reset(self) -> None:
        """Put the two direction times back."""
        self.good(self.write(cases.DIR_SETUP, cases.DIR_DEFAULT, cases.DIR_DEFAULT))

    # The cases.

    def c_coils_read(self) -> None:
        outputs = self.inputs(cases.OUTPUTS)[0]
        same(self.coils(cases.DRIVER_0), [bool(outputs & 1)])
        same(self.coils(cases.PERMIT), [bool(outputs >> 8 & 1)])

    def c_discrete_inputs_read(self) -> None:
        reply = self.good(self.client.read_discrete_inputs(0, count=16, **self.unit))
        status = self.inputs(cases.STATUS)[0]
        same(reply.bits[:16], [bool(status >> bit & 1) for bit in range(16)])

    def c_holding_registers_read(self) -> None:
        same(tuple(self.holdings(0, len(cases.DEFAULTS))), cases.DEFAULTS)

    def c_input_registers_read(self) -> None:
        version, _, board, axes = self.inputs(0, 4)
        number = boards.load(self.board).id
        same((version, board, axes), (regs.MAP_VERSION, number, boards.load(self.board).axes))

    def c_coil_written(self) -> None:
        for on in (True, False):
            self.good(self.client.write_coil(cases.DRIVER_0, on, **self.unit))
            same(self.coils(cases.DRIVER_0), [on])
            same(self.inputs(cases.OUTPUTS)[0] & 1, int(on))

    def c_register_written(self) -> None:
        reply = self.client.write_register(cases.DIR_SETUP, 33, **self.unit)
        same(self.good(reply).registers, [33])
        same(self.holdings(cases.DIR_SETUP), [33])
        self.reset()

    def c_loopback(self) -> None:
        reply = self.good(self.client.diag_query_data(b"\xa5\x37", **self.unit))
        same(bytes(reply.message), b"\xa5\x37")

    def c_counter_of_exceptions(self) -> None:
        def count() -> int:
            reply = self.client.diag_read_bus_exception_error_count(**self.unit)
            return _number(self.good(reply).message)

        before = count()
        self.refused(self.raw(3, 0, 0), 3)
        same(count(), before + 1)

    def c_coils_written(self) -> None:
        for on in (True, False):
            self.good(self.client.write_coils(cases.PERMIT, [on], **self.unit))
            same(self.coils(cases.PERMIT), [on])

    def c_registers_written(self) -> None:
        self.good(self.write(cases.DIR_SETUP, 41, 42))
        same(self.holdings(cases.DIR_SETUP, 2), [41, 42])
        self.reset()

    def c_server_id(self) -> None:
        reply = self.good(self.client.report_device_id(**self.unit))
        text = bytes(reply.identifier)
        if f"pixstep {self.board}".encode() not in text or reply.status:
            raise ConformanceError(f"{text!r}, status {reply.status}")

    def c_mask_write(self) -> None:
        self.good(
            self.client.mask_write_register(
                address=cases.DIR_SETUP, and_mask=0xFFF0, or_mask=0x0005, **self.unit
            )
        )
        same(self.holdings(cases.DIR_SETUP), [cases.DIR_DEFAULT & 0xFFF0 | 5])
        self.reset()

    def c_write_and_read(self) -> None:
        reply = self.client.readwrite_registers(
            read_address=cases.DIR_SETUP - 2,
            read_count=4,
            write_address=cases.DIR_SETUP,
            values=[51, 52],
            **self.unit,
        )
        same(self.good(reply).registers, [0, 1, 51, 52])
        self.reset()

    def c_device_identification(self) -> None:
        reply = self.good(
            self.client.read_device_information(read_code=1, object_id=0, **self.unit)
        )
        vendor, product, revision = (reply.information[index] for index in range(3))
        same((vendor, product), (b"pixstep", self.board.encode()))
        if not revision:
            raise ConformanceError("no revision")

    def c_file_record(self) -> None:
        # pymodbus counts the record's length in bytes and asks for half as many words.
        record = FileRecord(file_number=3, record_number=cases.DIR_SETUP, record_length=4)
        reply = self.client.read_file_record([record], **self.unit)
        data = self.good(reply).records[0].record_data
        same(data, struct.pack(">2H", cases.DIR_DEFAULT, cases.DIR_DEFAULT))

    def c_32_bit_pair_read(self) -> None:
        high, low = self.inputs(cases.PERIOD, 2)
        same(high << 16 | low, cases.period_ticks(self.board, 30))

    def c_32_bit_pair_written(self) -> None:
        self.good(self.write(cases.PIXEL_HZ, 0, 50))
        high, low = self.inputs(cases.PERIOD, 2)
        self.good(self.write(cases.PIXEL_HZ, 0, 30))
        same(high << 16 | low, cases.period_ticks(self.board, 50))

    def c_exception_01(self) -> None:
        self.refused(self.client.read_exception_status(**self.unit), 1)

    def c_exception_02(self) -> None:
        reply = self.client.read_holding_registers(len(cases.DEFAULTS) - 1, count=2, **self.unit)
        self.refused(reply, 2)

    def c_exception_03(self) -> None:
        self.refused(self.client.write_register(cases.DIR_SETUP, 0, **self.unit), 3)
        same(self.holdings(cases.DIR_SETUP), [cases.DIR_DEFAULT])

    def c_exception_06(self) -> None:
        next_block = self.inputs(0x0022)[0]
        self.good(self.write(cases.QUEUE, *cases.block(next_block)))
        reply = self.client.write_register(cases.DIR_SETUP, 33, **self.unit)
        self.good(self.write(cases.COMMAND, 1, cases.DISCARD))
        self.refused(reply, 6)
        same(self.holdings(cases.DIR_SETUP), [cases.DIR_DEFAULT])

    def c_broadcast(self) -> None:
        self.client.write_registers(
            cases.DIR_SETUP, [61, 62], device_id=0, no_response_expected=True
        )
        same(self.holdings(cases.DIR_SETUP, 2), [61, 62])
        self.reset()

    def c_nothing_by_halves(self) -> None:
        self.refused(self.write(cases.DIR_SETUP, 71, 0), 3)
        same(self.holdings(cases.DIR_SETUP), [cases.DIR_DEFAULT])

    def c_125_words_read(self) -> None:
        same(len(self.inputs(cases.RECORDS, 125)), 125)

    def c_126_words(self) -> None:
        self.refused(self.raw(3, 0, 126), 3)

    def c_123_words_written(self) -> None:
        self.refused(self.write(0, *[1] * 123), 2)

    def c_124_words(self) -> None:
        self.refused(self.raw(16, 0, 124, data=bytes([248, *[0] * 245])), 3)

    def c_121_words_in_23(self) -> None:
        reply = self.client.readwrite_registers(
            read_address=0, read_count=1, write_address=0, values=[1] * 121, **self.unit
        )
        self.refused(reply, 2)

    def c_2000_bits(self) -> None:
        self.refused(self.client.read_coils(0, count=2000, **self.unit), 2)

    def c_2001_bits(self) -> None:
        self.refused(self.raw(1, 0, 2001), 3)

    def c_1968_bits_written(self) -> None:
        self.refused(self.client.write_coils(0, [True] * 1968, **self.unit), 2)

    def c_1969_bits(self) -> None:
        self.refused(self.raw(15, 0, 1969, data=bytes([247, *[0] * 247])), 3)


def _number(message: object) -> int:
    """Return the number in a diagnostic reply."""
    if isinstance(message, bytes):
        return int.from_bytes(message, "big")
    return int(message[0] if isinstance(message, (list, tuple)) else str(message))
