# SPDX-License-Identifier: MIT
"""The drives of a machine's motors, for servers that move motors: on ports, or on simulated boards."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from pixstep.errors import UserError

if TYPE_CHECKING:
    from pixstep.machine.files import MachineFile
    from pixstep.motor_record import Drive
    from pixstep.server.journal import Log


@contextlib.contextmanager
def opened(
    machine: MachineFile, port: str | None, log: Log, *, simulate: bool
) -> Iterator[Mapping[str, Drive]]:
    """Yield a drive for each motor, by the motors' names."""
    del machine, port, log, simulate
    raise UserError("no drive for motors yet")
    yield {}
