# SPDX-License-Identifier: MIT
"""`pixstep board`: real boards, and the simulator's through its pseudo terminal."""

from pixstep.cli.board import (
    commands,
    find,
    get,
    home,
    log,
    move,
    put,
    selftest,
    settings,
    start,
    stop,
    upload,
    watch,
)
from pixstep.cli.board.group import board

for module in (
    find,
    get,
    put,
    settings,
    watch,
    upload,
    start,
    stop,
    commands,
    home,
    move,
    log,
    selftest,
):
    for command in module.COMMANDS:
        board.add_command(command)

COMMANDS = (board,)
