# SPDX-License-Identifier: MIT
"""Channel Access whose monitors keep their order among each other and before a put's completion.

caproto sends monitors by one task and the completion of a put by another, and holds monitors back
for some milliseconds when many come at once: a client then hears that its move is over before it
hears where the motor is. Here monitors are sent as they come, and a completion waits for all
monitors that were posted before it.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from typing import Any

import caproto
from caproto.asyncio.server import Context as _Context
from caproto.asyncio.server import VirtualCircuit as _VirtualCircuit
from caproto.server.common import DisconnectedCircuit

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
