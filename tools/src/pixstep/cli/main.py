# SPDX-License-Identifier: MIT
"""The tree of all commands, and the `pixstep` command: each is imported when it is called."""

import os

import click

from pixstep import __version__
from pixstep.cli import late
from pixstep.cli.command import Group, Late, group
from pixstep.operations import catalog


def _late(place: str, about: str) -> Late:
    return Late(f"pixstep.cli.{place}", about)


def _operation(words: str) -> Late:
    """Return the command of an operation."""
    place, about = catalog.OPERATIONS[words]
    return Late(f"pixstep.operations.{place}", about)


_LINE = {
    "make": _operation("line make"),
    "check": _operation("line check"),
    "show": _operation("line show"),
    "compensate": _operation("line compensate"),
    "import": _operation("line import"),
    "plan": _operation("line plan"),
    "sim": _operation("sim"),
}
_FILE = {
    "info": _operation("file info"),
    "check": _operation("file check"),
    "convert": _operation("file convert"),
}
_PROFILE = {
    "make": _operation("profile make"),
    "check": _operation("profile check"),
    "show": _operation("profile show"),
    "repair": _operation("profile repair"),
}
_MOVE = {name: _operation(f"move {name}") for name in ("make", "show", "sim")}
_HOME = {"sim": _operation("home sim")}
_TRAJECTORY = {
    name: _operation(f"trajectory {name}")
    for name in ("circle", "import", "export", "compensate", "show", "sim")
}
_SETTINGS = {
    "export": _operation("board settings export"),
    "import": _operation("board settings import"),
    "store": _operation("board settings store"),
    "defaults": _operation("board settings defaults"),
    "diff": _operation("board settings diff"),
}
_LOG = {
    "records": _operation("board log records"),
    "events": _operation("board log events"),
}
_BOARD = {
    "scan": _operation("board scan"),
    "info": _operation("board info"),
    "features": _operation("board features"),
    "get": _operation("board get"),
    "set": _operation("board set"),
    "watch": _operation("board watch"),
    "upload": _operation("board upload"),
    "start": _operation("board start"),
    "stop": _operation("board stop"),
    "arm": _operation("board arm"),
    "disarm": _operation("board disarm"),
    "clear": _operation("board clear"),
    "enable": _operation("board enable"),
    "disable": _operation("board disable"),
    "permit": _operation("board permit"),
    "home": _operation("board home"),
    "measure-play": _operation("board measure-play"),
    "move": _operation("board move"),
    "simulate": _operation("board simulate"),
    "run": _operation("board run"),
    "trajectory": _operation("board trajectory"),
    "selftest": _operation("board selftest"),
}
_MACHINE = {name: _operation(f"machine {name}") for name in ("new", "check", "show")}
_MAIN = {
    "limits": _operation("limits"),
    "sim": _operation("sim"),
    "ticks": _operation("line plan"),
    "plan": _operation("plan"),
    "demo": _operation("demo"),
    "flash": _operation("flash"),
    "bench": _late("late:BENCH", "Measure cycles, rates, CPU share, edge errors, waits, sizes."),
    "completion": _late(
        "completion:completion", "Complete commands, options and files in the shell: install it."
    ),
}


class _LogGroup(Group):
    """`log` by itself is `log records`."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Put the word in that was left out."""
        if not args or args[0] not in {*self.commands, *ctx.help_option_names}:
            args = ["records", *args]
        return super().parse_args(ctx, args)


class _MainGroup(Group):
    """`sim board` is `board simulate`, as long as there is no line file of that name."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Put the command's other name in."""
        if args[:2] == ["sim", "board"] and not os.path.lexists("board"):
            args = ["board", "simulate", *args[2:]]
        return super().parse_args(ctx, args)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Leave out what would only say that it is not installed."""
        names = super().list_commands(ctx)
        return names if late.have_dev() else [name for name in names if name not in late.OF_DEV]


@group("line", late=_LINE)
def line() -> None:
    """Make, check, plan and simulate line files."""


@group("machine", late=_MACHINE)
def machine() -> None:
    """Machine files: pixel clock, boards and motors, as defaults of all commands.

    A file is found by --machine, else by PIXSTEP_MACHINE, else as machine.toml in the current
    folder.
    """


@group("file", late=_FILE)
def file() -> None:
    """Look into, check, convert PRN, CSV and CSB.

    The format is recognised by the content. Layouts, quirks and messages: docs/FILES.md.
    """


@group("profile", late=_PROFILE)
def profile() -> None:
    """Make, check, repair and show acceleration profiles."""


@group("move", late=_MOVE)
def move() -> None:
    """Fast moves of exactly N steps by a CSV acceleration profile."""


@group("home", late=_HOME)
def home() -> None:
    """Find the home switch and make its edge position 0."""


@group("trajectory", late=_TRAJECTORY)
def trajectory() -> None:
    """Tables of two axes: circles, play taken up at reversals, the circle test."""


@group("settings", late=_SETTINGS)
def settings() -> None:
    """All settings: as a TOML file and back, stored, defaults."""


@click.group("log", cls=_LogGroup, late=_LOG)
def log() -> None:
    """Records pixel by pixel; the log of faults and resets.

    `log` by itself is `log records`.
    """


@group("board", late=_BOARD)
def board() -> None:
    """Talk to boards on a serial line: look, set, upload, start, home, move, log.

    What a command moves is stopped when Ctrl-C, SIGTERM or SIGHUP ends it.
    """


@click.group(
    "main", cls=_MainGroup, late=_MAIN, context_settings={"help_option_names": ["-h", "--help"]}
)
@click.version_option(__version__, prog_name="pixstep")
def main() -> None:
    """Line files to exact STEP edges: make, check, plan, simulate.

    Exit status of every command: 0 fine; 1 a negative verdict (warnings, a failed run, a board that
    did not do as asked); 2 misuse; 3 refused by a check or by a board; 130, 143, 129 ended by
    Ctrl-C, SIGTERM, SIGHUP.
    """


for _nested in (settings, log):
    board.add_command(_nested)
for _group in (line, machine, file, profile, move, home, trajectory, board):
    main.add_command(_group)
