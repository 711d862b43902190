# SPDX-License-Identifier: MIT
"""Motor records on Channel Access: what a client sees, in which order, above an ideal stepper."""

import asyncio

import caproto as ca
import pytest
from caproto import ChannelType

from ideal_drive import JOG, REST, IdealDrive, Stepper
from iocbench import FIELDS as GIVEN
from iocbench import served, until
from pixstep.ioc import common
from pixstep.ioc.server import Circuit
from pixstep.motor_record import FIELDS, FieldType, Msta

REC = "T:m"
DBR = {
    FieldType.DOUBLE: ChannelType.DOUBLE,
    FieldType.FLOAT: ChannelType.FLOAT,
    FieldType.LONG: ChannelType.LONG,
    FieldType.ULONG: ChannelType.DOUBLE,
    FieldType.SHORT: ChannelType.INT,
    FieldType.USHORT: ChannelType.LONG,
    FieldType.UCHAR: ChannelType.CHAR,
    FieldType.MENU: ChannelType.ENUM,
    FieldType.STRING: ChannelType.STRING,
    FieldType.LINK: ChannelType.STRING,
}


@pytest.fixture
def bench(monkeypatch):
    """Yield a server with one record, and a client."""
    with served(monkeypatch) as both:
        yield both


def test_every_field_has_epics_type_and_can_be_read(bench):
    _, wire = bench
    for name, field in common.ALL.items():
        found = wire.get(f"{REC}.{name}")
        assert found.data_type == DBR[field.type], name
    assert wire.value(f"{REC}.RTYP") == "motor"
    assert wire.value(f"{REC}.NAME") == REC
    assert wire.value(REC) == wire.value(f"{REC}.VAL")


def test_menus_have_the_texts_of_the_record(bench):
    _, wire = bench
    for name, field in FIELDS.items():
        if field.type is FieldType.MENU:
            found = wire.get(f"{REC}.{name}", ChannelType.CTRL_ENUM).metadata
            assert [bytes(one).decode() for one in found.enum_strings] == [*field.menu[:16]]


@pytest.mark.parametrize(
    ("field", "units", "low", "high"),
    [
        ("VAL", b"mm", -50, 50), ("RBV", b"mm", -50, 50), ("DVAL", b"mm", -50, 50),
        ("DRBV", b"mm", -50, 50), ("VELO", b"mm/sec", 0, 40), ("ACCL", b"sec", 0, 0),
        ("HLM", b"mm", 0, 0),
    ],
)  # fmt: skip
def test_numbers_have_units_digits_and_limits(bench, field, units, low, high):
    _, wire = bench
    found = wire.get(f"{REC}.{field}", ChannelType.CTRL_DOUBLE).metadata
    assert (found.units, found.precision) == (units, 3)
    assert (found.lower_ctrl_limit, found.upper_ctrl_limit) == (low, high)


def test_raw_positions_have_limits_in_steps(bench):
    _, wire = bench
    for field in ("RVAL", "RRBV"):
        found = wire.get(f"{REC}.{field}", ChannelType.CTRL_LONG).metadata
        assert (found.lower_ctrl_limit, found.upper_ctrl_limit) == (-5000, 5000)


def test_limits_follow_the_fields_that_they_come_from(bench):
    _, wire = bench
    assert wire.put(f"{REC}.HLM", 20.0) == ""
    assert wire.put(f"{REC}.EGU", b"deg") == ""
    found = wire.get(f"{REC}.VAL", ChannelType.CTRL_DOUBLE).metadata
    assert (found.upper_ctrl_limit, found.units) == (20, b"deg")


def test_a_text_of_a_number_has_the_digits_of_the_record(bench):
    _, wire = bench
    wire.put(f"{REC}.VAL", 1.0)
    assert wire.get(f"{REC}.RBV", ChannelType.STRING).data[0] == b"1.000"
    assert wire.get(f"{REC}.DIR", ChannelType.STRING).data[0] == b"Pos"


def test_a_put_ends_with_the_move_and_the_last_position_before(bench):
    (host, wire) = bench
    wire.monitor(f"{REC}.RBV", f"{REC}.DMOV", f"{REC}.VAL")
    wire.seen.clear()
    assert wire.put(f"{REC}.VAL", 3.0) == ""
    assert wire.saw(f"{REC}.DMOV") == [0, 1]
    assert wire.seen[:2] == [(f"{REC}.DMOV", 0), (f"{REC}.VAL", 3.0)]
    assert wire.seen[-1] == ("end", f"{REC}.VAL")
    last = [name for name, _ in wire.seen]
    assert last.index(f"{REC}.RBV") > 0
    assert max(k for k, name in enumerate(last) if name == f"{REC}.RBV") < max(
        k for k, name in enumerate(last) if name == f"{REC}.DMOV"
    )
    assert wire.saw(f"{REC}.RBV")[-1] == 3.0
    assert host.drives[REC].motor.steps == 300


def test_the_order_of_a_backlash_move(bench):
    _, wire = bench
    wire.put(f"{REC}.BDST", 0.5)
    followed = [f"{REC}.{name}" for name in ("DMOV", "VAL", "MIP", "MOVN")]
    wire.monitor(*followed)
    wire.seen.clear()
    assert wire.put(f"{REC}.VAL", -2.0) == ""
    short = [(name.removeprefix(f"{REC}."), value) for name, value in wire.seen]
    assert short == [
        ("DMOV", 0), ("VAL", -2.0), ("MIP", 32), ("MOVN", 1), ("MIP", 256), ("MOVN", 0),
        ("MOVN", 1), ("MIP", 0), ("MOVN", 0), ("DMOV", 1), ("end", f"{REC}.VAL"),
    ]  # fmt: skip


@pytest.mark.parametrize("target", [0.0, 100.0])
def test_a_move_of_nothing_and_a_refused_one_pulse_dmov(bench, target):
    host, wire = bench
    wire.monitor(f"{REC}.DMOV")
    wire.seen.clear()
    assert wire.put(f"{REC}.VAL", target) == ""
    assert wire.seen == [(f"{REC}.DMOV", 0), (f"{REC}.DMOV", 1), ("end", f"{REC}.VAL")]
    assert wire.value(f"{REC}.VAL") == 0
    assert wire.value(f"{REC}.LVIO") == (target == 100)
    assert host.drives[REC].motor.edges == []


def test_stop_by_the_same_connection_ends_the_put_where_the_motor_is(bench):
    host, wire = bench
    wire.monitor(f"{REC}.DMOV")
    move = wire.begin(f"{REC}.VAL", 40.0)
    until(lambda: host.drives[REC].motor.steps > 50)
    wire.begin(f"{REC}.STOP", 1, wait=False)
    assert wire.ended(move) == ""
    motor = host.drives[REC].motor
    assert 50 < motor.steps < 3000
    assert wire.value(f"{REC}.RBV") == wire.value(REC) == pytest.approx(motor.steps * 0.01)
    assert wire.value(f"{REC}.DMOV") == 1


def test_no_step_comes_after_the_end_of_a_move(bench):
    host, wire = bench
    wire.monitor(f"{REC}.DMOV", data_type=ChannelType.TIME_INT)
    for target in (0.3, -0.2, 0.1, 0.0) * 5:
        wire.put(f"{REC}.VAL", target)
        made = len(host.drives[REC].motor.edges)
        wire.listen(0.03)
        assert len(host.drives[REC].motor.edges) == made
        assert host.drives[REC].motor.steps == round(target * 100)


def test_puts_of_settings_and_of_a_second_target_in_a_move(bench):
    _, wire = bench
    first = wire.begin(f"{REC}.VAL", 10.0)
    assert wire.put(f"{REC}.DESC", b"other") == ""
    second = wire.begin(f"{REC}.VAL", 1.0)
    assert wire.ended(second) == wire.ended(first) == ""
    assert wire.value(f"{REC}.RBV") == 1.0
    assert wire.value(f"{REC}.DESC") == "other"


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("RBV", 1.0), ("MSTA", 1.0), ("RHLM", 1.0), ("RTYP", b"ai"), ("VAL", b"far"),
        ("DIR", b"Left"), ("SPMG", 9), ("VAL", float("nan")),
    ],
)  # fmt: skip
def test_what_a_record_does_not_take_is_an_error_of_the_write(bench, field, value):
    host, wire = bench
    data_type = ChannelType.STRING if isinstance(value, bytes) else None
    assert field in wire.put(f"{REC}.{field}", value, data_type)
    (refused,) = host.log.facts("refused")
    assert field in refused["reason"]
    assert refused["client"].startswith("test@")


def test_a_menu_takes_its_texts(bench):
    _, wire = bench
    assert wire.put(f"{REC}.DIR", b"Neg", ChannelType.STRING) == ""
    assert wire.value(f"{REC}.DIR") == 1


def test_a_jog_that_was_refused_at_a_limit_does_not_begin_later(bench):
    host, wire = bench
    wire.put(f"{REC}.DHLM", 0.5)
    wire.put(f"{REC}.DLLM", -0.5)
    wire.put(f"{REC}.JOGF", 1)
    assert (wire.value(f"{REC}.LVIO"), wire.value(f"{REC}.JOGF")) == (1, 0)
    wire.put(f"{REC}.DHLM", 40)
    wire.put(f"{REC}.DLLM", -40)
    wire.put(f"{REC}.VAL", 0.2)
    until(lambda: wire.value(f"{REC}.RBV") == 0.2 and wire.value(f"{REC}.DMOV") == 1)
    assert max(steps for _, steps in host.drives[REC].motor.edges) == 20


def test_a_limit_switch_ends_a_move_with_its_alarm(bench):
    host, wire = bench
    wire.put(f"{REC}.HLSV", 2)
    wire.monitor(f"{REC}.SEVR")
    host.drives[REC].set(highest=200)
    assert wire.put(f"{REC}.VAL", 5.0) == ""
    assert wire.value(f"{REC}.HLS") == 1
    assert wire.value(f"{REC}.RBV") == 2.0
    found = wire.get(f"{REC}.RBV", ChannelType.TIME_DOUBLE).metadata
    assert (found.status, found.severity) == (ca.AlarmStatus.HIGH, ca.AlarmSeverity.MAJOR_ALARM)
    assert wire.saw(f"{REC}.SEVR")[-1] == 2
    assert wire.put(f"{REC}.VAL", 1.0) == ""
    assert wire.value(f"{REC}.SEVR") == 0


def test_a_move_that_somebody_else_has_stopped_does_not_go_on(bench):
    """Retries are on: without a write of STOP the record would go on to the target."""
    host, wire = bench
    wire.put(f"{REC}.RTRY", 10)
    drive = host.drives[REC]
    wire.monitor(f"{REC}.RBV")
    put = wire.begin(f"{REC}.VAL", 5.0)
    wire.until(lambda: wire.saw(f"{REC}.RBV")[-1:] > [0.5])
    drive.stopped_elsewhere = True
    drive.set(state=REST)
    assert wire.ended(put) == ""
    rests = wire.value(f"{REC}.RBV")
    assert 0 < rests < 5.0
    assert (wire.value(f"{REC}.VAL"), wire.value(f"{REC}.DMOV")) == (rests, 1)
    drive.stopped_elsewhere = False
    assert wire.put(f"{REC}.VAL", 4.0) == ""
    assert wire.value(f"{REC}.RBV") == 4.0


def test_a_lost_board_is_an_alarm_and_the_other_axes_go_on(monkeypatch):
    drives = {f"T:{name}": IdealDrive(Stepper(home=1e8)) for name in "ab"}
    with served(monkeypatch, drives=drives) as (host, wire):
        wire.monitor("T:a.SEVR")
        drives["T:a"].set(faults=Msta.COMM_ERR)
        wire.until(lambda: wire.saw("T:a.SEVR")[-1:] == [3])
        assert wire.value("T:a.STAT") == 9
        assert wire.put("T:b.VAL", 1.0) == ""
        assert wire.value("T:b.RBV") == 1.0
        drives["T:a"].set(faults=Msta(0))
        wire.until(lambda: wire.saw("T:a.SEVR")[-1:] == [0])
        assert host.log.facts("connection lost") == [{"motor": "T:a"}]
        assert host.log.facts("connection back") == [{"motor": "T:a"}]


def test_a_record_whose_board_never_answered_is_there_and_refuses(monkeypatch):
    class Silent(IdealDrive):
        def connect(self, on_status):
            self._report = on_status

    monkeypatch.setattr("pixstep.ioc.server._FIRST_STATUS_S", 0.2)
    drives = {"T:m": Silent()}
    with served(monkeypatch, drives=drives) as (_, wire):
        found = wire.get("T:m.RBV", ChannelType.TIME_DOUBLE).metadata
        assert (found.status, found.severity) == (
            ca.AlarmStatus.UDF, ca.AlarmSeverity.INVALID_ALARM
        )  # fmt: skip
        assert [wire.value(f"T:m.{field}") for field in ("STAT", "SEVR", "UDF")] == [17, 3, 1]
        assert "has not answered yet" in wire.put("T:m.VAL", 1.0)
        assert wire.value("T:IOC:LOST") in (0, 1)
        until(lambda: wire.value("T:IOC:LOST") == 1)
        drives["T:m"]._thread.start()
        drives["T:m"].set()
        wire.monitor("T:m.SEVR")
        until(lambda: wire.value("T:m.UDF") == 0 and wire.put("T:m.VAL", 1.0) == "")
        assert wire.value("T:m.RBV") == 1.0


def test_a_motor_that_moves_when_its_record_begins_is_not_done(monkeypatch):
    class Once(IdealDrive):
        """Reports once: what a client sees until the next look at a board."""

        def connect(self, on_status):
            self.motor.state = JOG
            on_status(self.motor.status())

    with served(monkeypatch, drives={"T:m": Once()}) as (_, wire):
        until(lambda: wire.value("T:m.UDF") == 0)
        assert (wire.value("T:m.DMOV"), wire.value("T:m.MOVN")) == (0, 1)


def test_links_to_records_of_the_same_server(monkeypatch):
    drives = {f"T:{name}": IdealDrive(Stepper(home=1e8)) for name in "ab"}
    fields = {"T:b": {"OMSL": 1, "DOL": "T:a.RBV"}}
    with served(monkeypatch, drives=drives, fields=fields) as (host, wire):
        wire.put("T:a.VAL", 2.0)
        wire.put("T:b.PROC", 1)
        until(lambda: wire.value("T:b.RBV") == 2.0)
        wire.put("T:b.OMSL", 0)
        wire.put("T:b.RDBL", b"T:a.RBV")
        wire.put("T:b.RRES", 1.0)
        wire.put("T:b.URIP", 1)
        wire.put("T:a.VAL", 1.0)
        wire.put("T:b.STUP", 1)
        until(lambda: wire.value("T:b.RBV") == 1.0)
        wire.put("T:b.RDBL", b"X:nowhere")
        assert host.log.facts("dead link") == [
            {"motor": "T:b", "field": "RDBL", "names": "X:nowhere"}
        ]


def test_a_text_longer_than_epics_texts_is_whole_as_a_long_one(bench):
    _, wire = bench
    text = "x" * 39 + "y" * 60
    assert wire.put(f"{REC}.RDBL$", [*text.encode(), 0], ChannelType.CHAR) == ""
    assert wire.value(f"{REC}.RDBL") == text[:39]
    assert bytes(wire.get(f"{REC}.RDBL$", ChannelType.CHAR).data).rstrip(b"\0") == text.encode()


def test_the_server_has_pvs_of_its_own(bench):
    _, wire = bench
    before = wire.value("T:IOC:HEARTBEAT")
    until(lambda: wire.value("T:IOC:HEARTBEAT") > before)
    assert wire.value("T:IOC:MOTORS") == 1
    assert bytes(wire.get("T:IOC:RECORDS", ChannelType.CHAR).data).rstrip(b"\0") == b"T:m"
    for name in common.all_names("T:", [REC]):
        wire.get(name)


def test_the_end_stops_what_moves(monkeypatch):
    with served(monkeypatch) as (host, wire):
        wire.begin(f"{REC}.VAL", 40.0)
        until(lambda: host.drives[REC].motor.steps > 50)
    assert host.drives[REC].is_closed
    assert host.drives[REC].motor.steps < 3900
    assert GIVEN["DHLM"] == 50
    assert [event for event, _ in host.log.lines][-1] == "ended"


def test_a_client_that_does_not_read_is_let_go_and_the_others_go_on(monkeypatch):
    send = Circuit._send_monitors

    async def deaf(self, items):
        """Hang as a connection does whose other end reads nothing."""
        if self.client_hostname == "deaf":
            await asyncio.Event().wait()
        await send(self, items)

    monkeypatch.setattr(Circuit, "_send_monitors", deaf)
    monkeypatch.setattr("pixstep.ioc.server.MOST_MONITORS", 20)
    with served(monkeypatch) as (host, wire):
        other = host.wire("deaf")
        request = other.channel(f"{REC}.RBV").subscribe()
        other._send(request)
        wire.put(REC, 4.0)
        until(lambda: host.log.facts("channel access"))
        (facts,) = host.log.facts("channel access")
        assert "does not read: disconnected" in facts["text"]
        with pytest.raises(AssertionError, match=r"closed|nothing came"):
            other.get(f"{REC}.RBV")
        assert wire.put(REC, 1.0) == ""
        assert wire.value(f"{REC}.RBV") == 1.0
