# SPDX-License-Identifier: MIT
"""The tree of all commands, and the `pixstep` command: each is imported when it is called."""

import os

import click

from pixstep import __version__
from pixstep.cli import late
from pixstep.cli.command import Group, Late, group

_PLACE = "pixstep.cli."


def _late(place: str, about: str, *, machine: bool = False) -> Late:
    return Late(_PLACE + place, about, machine)


def _by_machine(place: str, about: str) -> Late:
    """Return a command that a machine file gives defaults."""
    return _late(place, about, machine=True)


_LINE = {
    "make": _by_machine(
        "line_make:line_make",
        "Make a line: up, constant speed, down, by a profile or by an acceleration.",
    ),
    "check": _by_machine(
        "line:line_check",
        "Check a line of a CSV or CSB file, and the file's form as `file check` does.",
    ),
    "show": _by_machine(
        "show:line_show",
        "Show speed, acceleration, jerk and position of a line: a table, with --plot a drawing.",
    ),
    "compensate": _by_machine(
        "reversal:line_compensate", "Take up the play at every reversal of a plain line."
    ),
    "import": _by_machine(
        "line_import:line_import",
        "Make a line of your own table: what a spreadsheet exports, or what numpy's savetxt "
        "writes.",
    ),
    "plan": _by_machine(
        "line:ticks",
        "Plan the edges of a line of a CSV or CSB with the native build of the firmware's core.",
    ),
    "sim": _by_machine(
        "sim:sim",
        "Run lines on a simulated board and judge every edge; one file (CSV, CSB) per axis.",
    ),
}
_FILE = {
    "info": _late("file:info", "Say what is in a file."),
    "check": _late("file:check", "List everything wrong with a file."),
    "convert": _late("file:convert", "Write a file in another format."),
}
_PROFILE = {
    "make": _by_machine(
        "profile_make:profile_make",
        "Make the shortest acceleration profile within limits of acceleration and jerk.",
    ),
    "check": _by_machine(
        "profile:profile_check", "Check a profile under every reading of its file."
    ),
    "show": _by_machine(
        "profile:profile_show",
        "Show speed, acceleration, jerk and position of a profile: a table, with --plot a drawing.",
    ),
    "repair": _by_machine(
        "profile_repair:profile_repair",
        "Repair a file for a smooth motor: counts that oscillate, or the speeds of a PRN.",
    ),
}
_MOVE = {
    "make": _by_machine(
        "move:move_make",
        "Write a move as a plain line: one signed count per pixel, the fewest pixels there are.",
    ),
    "show": _by_machine(
        "move:move_show", "Show a move: how fast in which pixels, how long, where."
    ),
    "sim": _by_machine(
        "move:move_sim",
        "Make a move on a simulated board and judge every STEP edge and where it ends.",
    ),
}
_HOME = {
    "sim": _by_machine(
        "home:home_sim",
        "Home a simulated axis by a CSV or CSB profile, and judge it by the simulator's own log.",
    ),
}
_TRAJECTORY = {
    "circle": _by_machine(
        "trajectory:circle_command",
        "Make the table of a circle, counter-clockwise from angle 0, in counts.",
    ),
    "import": _late(
        "trajectory:import_command",
        "Check a table of your own and write it as 16-byte records.",
    ),
    "export": _late(
        "trajectory:export_command",
        "Write a table as CSV or Parquet, by the end of the output's name.",
    ),
    "compensate": _by_machine(
        "trajectory:compensate_command",
        "Write a table with the play of both axes taken up at every reversal.",
    ),
    "show": _by_machine(
        "trajectory:show_command",
        "Show what is in a table and, with --play, what the load of a modelled machine does.",
    ),
    "sim": _by_machine(
        "trajectory:sim_command",
        "Run a table on two axes of a simulated board, and measure the circle that its loads make.",
    ),
}
_SETTINGS = {
    "export": _by_machine(
        "board.settings:export_command", "Write all settings in force to a TOML file."
    ),
    "import": _by_machine(
        "board.settings:import_command", "Set what a TOML file says, all or nothing; read it back."
    ),
    "store": _by_machine(
        "board.settings:store_command", "Store the settings in force: they outlast power."
    ),
    "defaults": _by_machine(
        "board.settings:defaults_command", "Put the default settings into force."
    ),
    "diff": _by_machine(
        "board.settings:diff_command", "Compare with a TOML file, or with the defaults."
    ),
}
_LOG = {
    "records": _by_machine(
        "board.log:records_command", "Write per-pixel records as CSV, each as it comes."
    ),
    "events": _by_machine("board.log:events_command", "Print faults and resets with their times."),
}
_BOARD = {
    "scan": _by_machine("board.find:scan_command", "Look for boards at every address of the line."),
    "info": _by_machine("board.find:info_command", "Show what boards are and how they are."),
    "features": _by_machine(
        "board.find:features_command", "Show what boards' images were built with."
    ),
    "get": _by_machine("board.get:get_command", "Read registers by name, or all of them."),
    "set": _by_machine(
        "board.put:set_command", "Change settings, all of them in one request: all or none."
    ),
    "watch": _by_machine("board.watch:watch_command", "Watch boards live; Ctrl-C ends it."),
    "upload": _by_machine(
        "board.upload:upload_command", "Queue lines, one file an axis; with --arm run them."
    ),
    "start": _by_machine(
        "board.start:start_command", "Start loaded lines, of several boards on one clock edge."
    ),
    "stop": _by_machine(
        "board.stop:stop_command", "Stop what moves, at once, and forget what is queued."
    ),
    "arm": _by_machine(
        "board.commands:arm_command", "Arm loaded axes by hand, with a token if wanted."
    ),
    "disarm": _by_machine("board.commands:disarm_command", "Disarm axes and discard their queues."),
    "clear": _by_machine("board.commands:clear_command", "Clear the latched fault."),
    "enable": _by_machine("board.commands:enable_command", "Switch drivers on: their motors hold."),
    "disable": _by_machine("board.commands:disable_command", "Switch drivers of axes at rest off."),
    "permit": _by_machine(
        "board.commands:permit_command", "Switch the permit output, the gate of a laser or spindle."
    ),
    "home": _by_machine(
        "board.home:home_command", "Home an axis: its switch's edge becomes position 0."
    ),
    "measure-play": _by_machine(
        "board.measureplay:measure_play_command",
        "Measure the play of an axis by its home switch.",
    ),
    "move": _by_machine("board.move:move_command", "Move an axis by exactly N steps."),
    "simulate": _by_machine(
        "board.simulate:simulate_command",
        "Simulate a board, and work its switches, clock and supply.",
    ),
    "run": _by_machine("board.program:run_command", "Run a motion program while it is planned."),
    "trajectory": _by_machine(
        "board.trajectory:trajectory_command",
        "Run a table of two axes, its play taken up or not.",
    ),
    "selftest": _by_machine(
        "board.selftest:selftest_command", "Walk through the wiring of a new board."
    ),
}
_MACHINE = {
    "new": _late(
        "machine:machine_new", "Begin a machine file: valid as it is, with a comment for every key."
    ),
    "check": _late(
        "machine:machine_check",
        "Check a machine file: every mistake with its line, key and value.",
    ),
    "show": _late(
        "machine:machine_show",
        "Show the machine in force: its file, clock, boards and motors, in steps and pixels.",
    ),
}
_MAIN = {
    "limits": _by_machine(
        "limits:limits_command",
        "Show what a board can do: rates, accelerations, shortest lines, reversals.",
    ),
    "sim": _by_machine(
        "sim:sim",
        "Run lines on a simulated board and judge every edge; one file (CSV, CSB) per axis.",
    ),
    "ticks": _by_machine(
        "line:ticks",
        "Plan the edges of a line of a CSV or CSB with the native build of the firmware's core.",
    ),
    "plan": _late(
        "plan:plan",
        "Plan a motion program of blended moves: a line for each motor, all of equal length.",
    ),
    "demo": _late(
        "sim:demo_command",
        "Worked example: profile, line, plan, simulated Mega, verdict, plots, VCD.",
    ),
    "flash": _by_machine(
        "flash:flash_command",
        "Write the firmware to a board by avrdude through its boot loader, then ask what it is.",
    ),
    "serve": _late(
        "serve:serve_command", "Own a bus, and let other programs reach it: consoles, Python, PLCs."
    ),
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
