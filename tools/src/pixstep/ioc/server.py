# SPDX-License-Identifier: MIT
"""The server of all records of one process: it runs in a thread of its own until it is closed.

Channel Access whose monitors keep their order among each other and before a put's completion.

caproto sends monitors by one task and the completion of a put by another, and holds monitors back
for some milliseconds when many come at once: a client then hears that its move is over before it
hears where the motor is. Here monitors are sent as they come, and a completion waits for all
monitors that were posted before it.

PVs of the server itself: whether it lives, since when, and which PVs it has.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import caproto
from caproto.asyncio.server import Context as _Context
from caproto.asyncio.server import VirtualCircuit as _VirtualCircuit
from caproto.server.common import DisconnectedCircuit

from pixstep.errors import PlainError, UserError, one_line
from pixstep.ioc.common import GROUP
from pixstep.ioc.motors import ServedMotor
from pixstep.version import __version__

if TYPE_CHECKING:
    from pixstep.ioc.channels import FieldChannel
    from pixstep.ioc.saved import Saved
    from pixstep.motor_record import Drive
    from pixstep.motor_record.field import Value
    from pixstep.server.journal import Log


MOST_MONITORS = 10_000  # of a client that wait for being sent
_PATIENCE_S = 5.0  # a client that reads nothing for longer gets the completion out of order


class _Marker:
    """Passes through the queues of monitors, and tells when all before it have been sent."""

    def __init__(self) -> None:
        self.passed = asyncio.Event()


class _Backlog(asyncio.Queue[Any]):
    """Monitors of one client; one that lets it become full must not keep the others waiting."""

    def __init__(self, overflow: Callable[[], None]) -> None:
        super().__init__(MOST_MONITORS)
        self._overflow = overflow

    async def put(self, item: Any) -> None:
        """Add a monitor; where there is no room for it, tell that."""
        if self.full():
            self._overflow()
        else:
            self.put_nowait(item)


class Circuit(_VirtualCircuit):  # type: ignore[misc]  # caproto has no types
    """One client's connection."""

    def __init__(self, *given: Any, **more: Any) -> None:
        super().__init__(*given, **more)
        self.subscription_queue = _Backlog(self._give_up)
        self._is_given_up = False

    def _give_up(self) -> None:
        """End the connection: the client, if it lives, comes back and is told all values again."""
        if not self._is_given_up:
            self.log.warning("%s:%d does not read: disconnected", *self.circuit.address)
            self._is_given_up = True
            self.client.writer.transport.abort()

    async def send(self, *commands: Any) -> None:
        """Send commands; the completion of a put comes after the monitors before it."""
        if any(isinstance(one, caproto.WriteNotifyResponse) for one in commands):
            await self._after_monitors()
        await super().send(*commands)

    async def _after_monitors(self) -> None:
        marker = _Marker()
        await self.context.subscription_queue.put((marker, None, None, 0, self))
        with contextlib.suppress(asyncio.TimeoutError):
            await asyncio.wait_for(marker.passed.wait(), _PATIENCE_S)

    async def subscription_queue_loop(self) -> None:
        """Send monitors as they come, all that are there at once."""
        self.events_on.set()
        try:
            while True:
                items = [await self.subscription_queue.get()]
                while not self.subscription_queue.empty():
                    items.append(self.subscription_queue.get_nowait())
                await self._send_monitors(items)
        except asyncio.CancelledError:
            pass
        except DisconnectedCircuit:
            await self._on_disconnect()
            self.circuit.disconnect()
            await self.context.circuit_disconnected(self)

    async def _send_monitors(self, items: list[Any]) -> None:
        """Send what is still wanted: a monitor that was cancelled meanwhile is not sent."""
        markers = [one for one in items if isinstance(one, _Marker)]
        commands = [one() for one in items if not isinstance(one, _Marker)]
        wanted = {sub.subscriptionid for subs in self.subscriptions.values() for sub in subs}
        sent = [one for one in commands if one is not None and one.subscriptionid in wanted]
        try:
            if sent:
                await super().send(*sent)
        finally:
            for marker in markers:
                marker.passed.set()


class Context(_Context):  # type: ignore[misc]
    """The server of all PVs of one process."""

    CircuitClass = Circuit

    async def _subscription_queue_iteration(
        self, sub_specs: Any, metadata: Any, values: Any, flags: int, sub: Any
    ) -> None:
        if isinstance(sub_specs, _Marker):
            await sub.subscription_queue.put(sub_specs)
            return
        await super()._subscription_queue_iteration(sub_specs, metadata, values, flags, sub)


_NAMES_BYTES = 65_536


class StatusPvs:
    """The PVs of the server."""

    def __init__(self, records: Iterable[str]) -> None:
        names = "\n".join(records)
        self._began_s = time.monotonic()
        self._pvs: dict[str, Any] = {
            "HEARTBEAT": caproto.ChannelInteger(value=0),
            "UPTIME": caproto.ChannelString(value=_span(0)),
            "STARTTOD": caproto.ChannelString(value=_clock()),
            "VERSION": caproto.ChannelString(value=__version__),
            "MOTORS": caproto.ChannelInteger(value=len(names.split())),
            "LOST": caproto.ChannelInteger(value=0),
            "SAVED": caproto.ChannelString(value=""),
            "RECORDS": caproto.ChannelChar(value=names, max_length=_NAMES_BYTES),
        }
        for pv in self._pvs.values():
            pv.check_access = _read_only

    def named(self, prefix: str) -> Mapping[str, Any]:
        """Return the PVs by their names."""
        return {f"{prefix}{GROUP}{name}": pv for name, pv in self._pvs.items()}

    async def beat(self, lost: int) -> None:
        """Show that the server lives."""
        beats = self._pvs["HEARTBEAT"]
        await beats.write((beats.value + 1) & 0x7FFF_FFFF)
        await self._pvs["UPTIME"].write(_span(time.monotonic() - self._began_s))
        if self._pvs["LOST"].value != lost:
            await self._pvs["LOST"].write(lost)

    async def note_saved(self) -> None:
        """Show that the file has been written."""
        await self._pvs["SAVED"].write(_clock())


def _read_only(hostname: str, username: str) -> Any:
    del hostname, username
    return caproto.AccessRights.READ


def _clock() -> str:
    return time.strftime("%Y-%m-%d %H:%M:%S")


def _span(seconds: float) -> str:
    minutes, second = divmod(int(seconds), 60)
    hours, minute = divmod(minutes, 60)
    days, hour = divmod(hours, 24)
    return f"{days} days, {hour:02}:{minute:02}:{second:02}"


_FIRST_STATUS_S = 5.0  # for boards to answer before their records are served without them
_BEAT_S = 1.0
_STOP_S = 3.0  # for motors to come to rest when the server ends
_END_S = 5.0


@dataclass(frozen=True)
class MotorSpec:
    """A motor to be served: its record's name, the fields of its machine file, its drive."""

    record: str
    fields: Mapping[str, Value]
    drive: Drive


class RecordServer:
    """Records on Channel Access: `start`, `wait`, `close`."""

    def __init__(self, motors: Sequence[MotorSpec], prefix: str, saved: Saved, log: Log) -> None:
        self._given = {motor.record: motor.fields for motor in motors}
        self._specs, self._prefix, self._saved, self._log = motors, prefix, saved, log
        self._motors: list[ServedMotor] = []
        self._fields: dict[str, FieldChannel] = {}
        self._thread = threading.Thread(target=self._run, name="ioc", daemon=True)
        self._is_up, self._is_over = threading.Event(), threading.Event()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._end: asyncio.Event | None = None
        self._failure: Exception | None = None

    def start(self) -> None:
        """Begin, and return when clients can connect. Raises UserError if they never can."""
        self._thread.start()
        self._is_up.wait()
        self._raise_failure()

    def wait(self) -> None:
        """Wait until a signal ends this. Raises UserError if the server fails."""
        self._is_over.wait()
        self._raise_failure()

    def close(self) -> None:
        """Stop the motors, keep what is to be kept, and let the clients go."""
        if self._loop is not None and self._end is not None:
            with contextlib.suppress(RuntimeError):  # it has ended by itself
                self._loop.call_soon_threadsafe(self._end.set)
        if self._thread.ident is not None:
            self._thread.join(_STOP_S + 2 * _END_S)

    def _raise_failure(self) -> None:
        if self._failure is not None:
            raise self._failure

    def _run(self) -> None:
        try:
            with _told_by(self._log):
                asyncio.run(self._serve())
        except PlainError as error:
            self._failure = error
        except (OSError, OverflowError, caproto.CaprotoError) as error:
            self._failure = UserError(
                f"Channel Access: {_reason(error)} (EPICS_CAS_INTF_ADDR_LIST, "
                f"EPICS_CA_SERVER_PORT say where it listens)"
            )
        except Exception as error:  # a thread's traceback helps nobody who runs a server
            self._failure = UserError(f"the server ended: {type(error).__name__}: {error}")
        finally:
            self._is_up.set()
            self._is_over.set()

    async def _serve(self) -> None:
        self._loop, self._end = asyncio.get_running_loop(), asyncio.Event()
        self._loop.set_exception_handler(self._tell_of_exception)
        self._motors = [self._made(spec) for spec in self._specs]
        tasks = [asyncio.create_task(motor.run()) for motor in self._motors]
        try:
            await self._first_statuses()
            status = StatusPvs(motor.name for motor in self._motors)
            pvs = self._named_pvs() | dict(status.named(self._prefix))
            context = Context(pvs)
            tasks.append(asyncio.create_task(self._beat(status)))
            serving = asyncio.create_task(context.run(startup_hook=self._tell_of_start(context)))
            ending = asyncio.create_task(self._end.wait())
            await asyncio.wait({serving, ending, *tasks}, return_when=asyncio.FIRST_COMPLETED)
            failed = [one for one in (serving, *tasks) if one.done()]
            await self._stop_motors()
            for one in failed:
                one.result()
            serving.cancel()
            await asyncio.wait({serving}, timeout=_END_S)
        finally:
            for motor in self._motors:
                motor.close()
            for task in tasks:
                task.cancel()
            self._keep()
            self._log.tell("ended", motors=len(self._motors))

    def _made(self, spec: MotorSpec) -> ServedMotor:
        kept = self._saved.kept(spec.record, spec.fields)
        if kept.is_moving:
            self._log.tell("was moving when the last IOC ended", motor=spec.record)
        return ServedMotor(spec.record, kept, spec.drive, self._log.tell, self._fields.get)

    async def _first_statuses(self) -> None:
        """Wait a while for all boards, so that clients never see positions that nobody knows."""
        waits = [asyncio.create_task(motor.ready.wait()) for motor in self._motors]
        _, missing = await asyncio.wait(waits, timeout=_FIRST_STATUS_S)
        for wait in missing:
            wait.cancel()
        for motor in self._motors:
            if not motor.is_ready:
                self._log.tell("no board yet", motor=motor.name, **motor.why)

    def _named_pvs(self) -> dict[str, Any]:
        for motor in self._motors:
            self._fields |= {f"{motor.name}.{name}": pv for name, pv in motor.pvs.items()}
            self._fields[motor.name] = motor.pvs["VAL"]
        return dict(self._fields)

    def _tell_of_start(self, context: Context) -> Any:
        async def tell(library: Any) -> None:
            del library
            self._log.tell(
                "serving", records=len(self._motors), pvs=len(context.pvdb), tcp=context.port,
                interfaces=" ".join(context.interfaces),
            )  # fmt: skip
            self._is_up.set()

        return tell

    async def _beat(self, status: StatusPvs) -> None:
        """Show each second that the server lives, and keep what has changed."""
        while True:
            await asyncio.sleep(_BEAT_S)
            await status.beat(sum(not motor.is_ready or motor.is_lost for motor in self._motors))
            self._note()
            try:
                if await asyncio.to_thread(self._saved.write):
                    await status.note_saved()
            except PlainError as error:
                self._log.tell("not saved", why=str(error))

    def _note(self) -> None:
        for motor in self._motors:
            if motor.is_ready:
                self._saved.note(
                    motor.name, self._given[motor.name], motor.record,
                    is_moving=motor.is_moving, offset_steps=motor.offset_steps,
                )  # fmt: skip

    def _keep(self) -> None:
        """Keep the last state."""
        self._note()
        try:
            self._saved.write()
        except PlainError as error:
            self._log.tell("not saved", why=str(error))

    async def _stop_motors(self) -> None:
        """Stop what moves, and wait until it rests."""
        stops = [asyncio.create_task(motor.stop()) for motor in self._motors]
        if stops:
            await asyncio.wait(stops, timeout=_STOP_S)

    def _tell_of_exception(self, loop: Any, context: dict[str, Any]) -> None:
        del loop
        error = context.get("exception")
        self._log.tell("trouble", what=_reason(error) if error else context.get("message"))


def _reason(error: BaseException) -> str:
    """Return the reason of a failure as one line."""
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    cause = error.__cause__
    return one_line(f"{error}{f': {_reason(cause)}' if cause else ''}") or type(error).__name__


def _is_unheard(error: BaseException | None) -> bool:
    """True for a beacon that nobody listens to: clients find the server without."""
    return error is not None and isinstance(error.__cause__, ConnectionRefusedError)


_ONCE = (
    "Failed to send beacon to %r. Try setting EPICS_CAS_AUTO_BEACON_ADDR_LIST=no and "
    "EPICS_CAS_BEACON_ADDR_LIST=<addresses>.",
)


class _LogHandler(logging.Handler):
    """Turns what caproto logs into lines of our log: a line each, without a traceback."""

    def __init__(self, log: Log) -> None:
        super().__init__(logging.WARNING)
        self._log = log
        self._told: set[str] = set()

    def emit(self, record: logging.LogRecord) -> None:
        """Tell one thing."""
        error = record.exc_info[1] if record.exc_info else None
        if isinstance(error, PlainError):  # a write that a record refuses
            self._log.tell("refused", client=_client(record), reason=str(error))
            return
        text = one_line(record.getMessage())
        if record.msg in _ONCE:  # it comes again each 15 s
            if text in self._told or _is_unheard(error):
                return
            self._told.add(text)
        self._log.tell("channel access", text=f"{text}: {_reason(error)}" if error else text)


def _client(record: logging.LogRecord) -> str:
    """Return who has written: user and host, as caproto's message has them."""
    named = record.args[:2] if isinstance(record.args, tuple) else ()
    return "@".join(str(one) for one in named)


@contextlib.contextmanager
def _told_by(log: Log) -> Any:
    """Let caproto's messages be told by our log."""
    logger = logging.getLogger("caproto")
    handler, spreads = _LogHandler(log), logger.propagate
    logger.addHandler(handler)
    logger.propagate = False
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.propagate = spreads
