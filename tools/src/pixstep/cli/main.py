# SPDX-License-Identifier: MIT
"""The tree of all commands, and the `pixstep` command: each is imported when it is called."""

import click

from pixstep.cli import late
from pixstep.cli.command import Group, LazyCommand, group
from pixstep.operations import catalog
from pixstep.version import __version__


def _operation(words: str) -> LazyCommand:
    """Return the command of an operation."""
    place, about = catalog.OPERATIONS[words]
    return LazyCommand(f"pixstep.operations.{place}", about)


def _under(group: str) -> dict[str, LazyCommand]:
    """Return the commands of the operations that stand in a group, by their last word."""
    parted = (words.rpartition(" ") for words in catalog.OPERATIONS)
    return {
        name: _operation(f"{above} {name}".strip()) for above, _, name in parted if above == group
    }


_MAIN = {
    "bench": LazyCommand("pixstep.cli.late:BENCH", late.ABOUT),
    "completion": LazyCommand(
        "pixstep.cli.completion:completion",
        "Complete commands, options and files in the shell: install it.",
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
    """The command `pixstep` itself."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Leave out what would only say that it is not installed."""
        names = super().list_commands(ctx)
        return names if late.have_dev() else [name for name in names if name not in late.OF_DEV]


@group("line", late=_under("line"))
def line() -> None:
    """Make, check and show line files; `sim` simulates them, `ticks` plans their edges."""


@group("machine", late=_under("machine"))
def machine() -> None:
    """Machine files: pixel clock, boards and motors, as defaults of all commands.

    A file is found by --machine, else by PIXSTEP_MACHINE, else as machine.toml in the current
    folder.
    """


@group("job", late=_under("job"))
def job() -> None:
    """Print jobs: many lines of several motors in one file, with their configuration.

    A job is compared with the machine file of today and with what the boards hold.
    """


@group("file", late=_under("file"))
def file() -> None:
    """Look into, check, convert PRN, CSV and CSB.

    The format is recognised by the content. Layouts, quirks and messages: docs/FILES.md.
    """


@group("profile", late=_under("profile"))
def profile() -> None:
    """Make, check, repair and show acceleration profiles."""


@group("move", late=_under("move"))
def move() -> None:
    """Fast moves of exactly N steps by a CSV acceleration profile."""


@group("home", late=_under("home"))
def home() -> None:
    """Find the home switch and make its edge position 0."""


@group("trajectory", late=_under("trajectory"))
def trajectory() -> None:
    """Tables of two axes: circles, play taken up at reversals, the circle test."""


@group("settings", late=_under("board settings"))
def settings() -> None:
    """All settings: as a TOML file and back, stored, defaults."""


@click.group("log", cls=_LogGroup, late=_under("board log"))
def log() -> None:
    """Records pixel by pixel; the log of faults and resets.

    `log` by itself is `log records`.
    """


@group("board", late=_under("board"))
def board() -> None:
    """Talk to boards on a serial line: look, set, upload, start, home, move, log.

    What a command moves is stopped when Ctrl-C, SIGTERM or SIGHUP ends it.
    """


def _print_version(ctx: click.Context, _: click.Parameter, wanted: bool) -> None:
    """Print what this is, and end."""
    if wanted:
        from pixstep import natives
        from pixstep.board.registers import MAP_VERSION

        commit = natives.commit() or "unknown"
        click.echo(f"pixstep, version {__version__} (commit {commit}, register map {MAP_VERSION})")
        ctx.exit()


@click.group(
    "main",
    cls=_MainGroup,
    late=_under("") | _MAIN,
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_print_version,
    help="Show the version, the commit and the boards' register map.",
)
def main() -> None:
    """Steppers that follow a pixel clock: lines, boards, simulation.

    Exit status of every command: 0 fine; 1 a negative verdict (warnings, a failed run, a board that
    did not do as asked); 2 misuse; 3 refused by a check or by a board; 130, 143, 129 ended by
    Ctrl-C, SIGTERM, SIGHUP.
    """


for _nested in (settings, log):
    board.add_command(_nested)
for _group in (line, job, machine, file, profile, move, home, trajectory, board):
    main.add_command(_group)
