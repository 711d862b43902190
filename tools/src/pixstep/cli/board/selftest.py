# SPDX-License-Identifier: MIT
"""`pixstep board selftest`: is everything wired as it should be?"""

import click

from pixstep.board import selftest
from pixstep.board.port import Port
from pixstep.board.selftest import FAILED, OK, Result, SelfTest
from pixstep.cli.board.group import axes_option, one_board, port_options, unit_option
from pixstep.cli.command import command
from pixstep.cli.options import json_option, show_json
from pixstep.cli.quantities import StepsType, TimeType

_COLOURS = {OK: "green", FAILED: "red", selftest.SKIPPED: "yellow"}


class _Asked:
    """The person at the terminal; asked on the error stream, so that --json stays clean."""

    def agrees(self, question: str, *, default: bool = True) -> bool:
        """Ask for yes or no."""
        return click.confirm(question, default=default, err=True)

    def says(self, text: str) -> None:
        """Tell what to do now."""
        click.echo(text, err=True)


@command("selftest")
@port_options
@unit_option
@axes_option
@click.option("--yes", is_flag=True, help="Ask nothing: only what needs nobody at the machine.")
@click.option(
    "--limit",
    "limit_s",
    type=TimeType("s", 1, 600),
    default="30s",
    show_default=True,
    help="Time to wait for a switch.",
)
@click.option(
    "--steps",
    type=StepsType(1, 100_000),
    default=200,
    show_default=True,
    help="Slow steps to turn each motor, and back.",
)
@json_option
@click.pass_context
def selftest_command(
    ctx: click.Context,
    port: Port,
    unit: int,
    axes: tuple[int, ...],
    yes: bool,
    limit_s: float,
    steps: int,
    as_json: bool,
) -> None:
    """Walk through the wiring of a new board.

    Supply, clock, switches, motors, permit output, emergency stop. It asks before anything moves or
    is switched on. Exit status 0 if nothing failed; what was left out is listed.
    """
    with one_board(port, unit) as (found, known):
        person = None if yes else _Asked()
        test = SelfTest(
            known.board, known.who, found.world, person, known.axes(axes), limit_s, steps
        )
        test.go(lambda result: None if as_json else _print(result))
    if as_json:
        show_json({
            "unit": unit, "board": known.who.board, "passed": test.passed,
            "checks": [result.as_json() for result in test.results],
        })  # fmt: skip
    else:
        _print_end(test)
    ctx.exit(0 if test.passed else 1)


def _print(result: Result) -> None:
    verdict = click.style(f"{result.verdict:<8}", fg=_COLOURS[result.verdict])
    click.echo(f"{verdict}{result.name}: {result.text}")


def _print_end(test: SelfTest) -> None:
    counts = {
        verdict: sum(result.verdict == verdict for result in test.results)
        for verdict in (OK, FAILED, selftest.SKIPPED)
    }
    click.echo(", ".join(f"{count} {verdict}" for verdict, count in counts.items()))
