# SPDX-License-Identifier: MIT
"""A click command from an operation: its options, help and page, and nothing of its own.

What click itself knows of the kinds of values is left to it.
"""

from __future__ import annotations

import contextlib
import functools
import json
import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from pixstep import atomic, progress
from pixstep.cli import command, failures, origins, views
from pixstep.cli.command import Command
from pixstep.errors import RefusedError, UserError, one_line, told
from pixstep.machine import FILE_NAME, VARIABLE
from pixstep.operations import kinds, perform
from pixstep.operations.asked import AskedError, Field, FieldError, MissingError
from pixstep.operations.desk import Desk, Source
from pixstep.operations.kinds import Flag
from pixstep.operations.perform import Caller
from pixstep.operations.request import Request, fields
from pixstep.operations.result import Result

if TYPE_CHECKING:
    import rich.console

    from pixstep.operations.facts import Facts


JsonFacts = Mapping[str, object]  # plain data, for JSON
SCHEMA = 1  # of all --json output; a field that is added does not change it


def teller(output: Path | None) -> Callable[..., None]:
    """Return `click.echo` on the stream that is free for words: not the one the output goes to."""
    return functools.partial(click.echo, err=atomic.is_stdout(output))


def show_json(facts: JsonFacts) -> None:
    """Print facts as JSON, with the version of its layout and the machine file that was used."""
    machine = origins.told(click.get_current_context(silent=True))
    click.echo(json.dumps({"schema": SCHEMA, **machine, **facts}, indent=2))


def show_json_row(facts: JsonFacts) -> None:
    """Print facts as one row of JSON, where more rows follow as they come."""
    click.echo(json.dumps({"schema": SCHEMA, **facts}))


def say(notes: Iterable[str]) -> None:
    """Print notes to the error stream."""
    for note in notes:
        click.echo(f"note: {one_line(note)}", err=True)


class FiniteRange(click.FloatRange):
    """A number between two others: "nan" is neither too small nor too large, but no number."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Parse the text; a bad one is a usage error."""
        number: float = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{value!r} is not a number.", param, ctx)
        return number


class KindType(click.ParamType[Any, Any]):
    """A value that its kind reads; one that may need a motor's scale is read later."""

    def __init__(self, kind: kinds.Kind):
        self.kind = kind
        self.name = kind.name

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read the text; a bad one is a usage error."""
        if self.kind.scaled:
            return value
        try:
            return self.kind.read(value)
        except UserError as error:
            return self.fail(str(error), param, ctx)


class OutType(command.OutFileType):
    """A file that is written, whose kind has more to say of its name."""

    def __init__(self, kind: kinds.OutFile):
        super().__init__(folder=kind.folder)
        self.kind = kind

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Refuse a name that the kind refuses."""
        return self.kind.judge(Path(os.fsdecode(super().convert(value, param, ctx))))


def click_type(kind: kinds.Kind) -> click.ParamType[Any, Any]:
    """Return what reads values of a kind on the command line."""
    for known, make in _TYPES.items():
        if type(kind) is known or (known is kinds.Text and isinstance(kind, known)):
            found: click.ParamType[Any, Any] = make(kind)
            return found
    return OutType(kind) if isinstance(kind, kinds.OutFile) else KindType(kind)


_TYPES: dict[type[kinds.Kind], Any] = {
    kinds.Whole: lambda kind: (
        click.INT if kind.least is kind.most is None else click.IntRange(kind.least, kind.most)
    ),
    kinds.Number: lambda kind: FiniteRange(kind.least, kind.most),
    kinds.Choice: lambda kind: click.Choice(kind.words, case_sensitive=not kind.any_case),
    kinds.Text: lambda _: click.STRING,
    kinds.InFile: lambda _: command.FILE,
    kinds.AnyPath: lambda _: click.Path(path_type=Path),
    kinds.OutFile: lambda kind: command.OUTPUT_OR_FOLDER if kind.folder else command.OUTPUT,
    kinds.OutPicture: lambda _: command.PICTURE,
    kinds.OutFolder: lambda _: command.FOLDER,
}


_ASKED = "pixstep.request"
FACTS_HELP = "Print facts as JSON, for programs."
_GIVEN = (ParameterSource.COMMANDLINE, ParameterSource.ENVIRONMENT)


class _Later:
    """A parameter whose value may come from the machine file, which is asked later."""

    def value_is_missing(self, value: Any) -> bool:
        """Leave that to the request."""
        del value
        return False


class _Option(_Later, click.Option):
    """An option of an operation."""


class _Argument(_Later, click.Argument):
    """An argument of an operation."""


class OperationCommand(Command):
    """The command of an operation."""

    def __init__(self, request: type[Request]):
        self.request = request
        known = fields(request)
        params = [_parameter(one) for one in known.values()]
        if request.has_json:
            rows = f"One line of JSON for each {request.json_rows}." if request.json_rows else ""
            params.append(_flag("--json", "as_json", rows or FACTS_HELP))
        super().__init__(
            request.words.split()[-1], params=params, help=request.__doc__, callback=_run
        )
        self.by_machine = any(one.machine for one in known.values())
        if self.by_machine and not request.own_motor:
            self._add_motor(several=any(known[name].many for name in ("decode", "play")
                                        if name in known))  # fmt: skip
        if self.by_machine or request.needs_machine:
            self._add_machine()

    def _add_motor(self, *, several: bool) -> None:
        once = ", once for each line" if several else ""
        self.params.append(
            click.Option(
                ["--motor"], metavar="NAME", multiple=True, expose_value=False,
                callback=_note_motors if several else _note_motor,
                help=f"Motor of the machine file{once}.",
            )
        )  # fmt: skip

    def _add_machine(self) -> None:
        about = "with defaults, or `none`" if self.by_machine else "with motors and limits"
        self.params.append(
            click.Option(
                ["--machine"], metavar="FILE", envvar=VARIABLE, show_envvar=True,
                expose_value=False, callback=_note_machine,
                help=f"Machine file {about}.  [default: {FILE_NAME} in the current folder]",
            )
        )  # fmt: skip

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the command line into a request."""
        with _explained(ctx, self.request):
            left = super().parse_args(ctx, args)
            if not ctx.resilient_parsing:
                self._resolve(ctx)
            return left

    def invoke(self, ctx: click.Context) -> object:
        """Run the command under the rules for its files; errors name options and the file."""
        with _explained(ctx, self.request):
            return super().invoke(ctx)

    def _resolve(self, ctx: click.Context) -> None:
        names = fields(self.request)
        given = {
            name: ctx.params[name] for name in names if ctx.get_parameter_source(name) in _GIVEN
        }
        caller = Caller(ctx.meta.get("machine"), ctx.meta.get("motors", ()), look=True)
        facts = perform.facts_of(self.request, given, caller)
        self.request.prepare(facts, _sayer(self.request))
        if self.by_machine or self.request.needs_machine:
            origins.hold(ctx, facts)
        try:
            request, sources = perform.resolve(self.request, given, facts)
        except FieldError as error:
            raise self._said(ctx, error, given) from None
        for name, source in sources.items():
            ctx.params[name] = getattr(request, name)
            if source is Source.MACHINE:
                ctx.set_parameter_source(name, ParameterSource.DEFAULT_MAP)
        ctx.meta[_ASKED] = request, facts, sources

    def _said(self, ctx: click.Context, error: FieldError, given: dict[str, Any]) -> Exception:
        """Return what click would raise for a value, which is said as for all others."""
        param = next(one for one in self.params if one.name == error.field.name)
        if isinstance(error, MissingError):
            return click.MissingParameter(ctx=ctx, param=param)
        if error.field.name not in given:
            ctx.set_parameter_source(error.field.name, ParameterSource.DEFAULT_MAP)
        return click.BadParameter(told(error.reason, _words(self.request)), ctx=ctx, param=param)


@functools.cache
def command_of(request: type[Request]) -> OperationCommand:
    """Return the command of an operation; one that has two names is one command."""
    return OperationCommand(request)


def _parameter(one: Field) -> click.Parameter:
    kind = click_type(one.kind)
    if one.argument:
        found = _Argument(
            [one.name], type=kind, required=one.required, nargs=-1 if one.many else 1,
            metavar=one.shown, envvar=one.variable,
        )  # fmt: skip
        found.default = None
        return found
    is_flag = isinstance(one.kind, Flag)
    more: dict[str, Any] = {"flag_value": one.alone} if one.alone else {}
    names = list(one.names)
    if is_flag and one.off:
        names = [f"{max(names, key=len)}/{one.off}"]
    if one.unless:
        return _Option(
            [*names, one.name], is_flag=True, default=True, flag_value=False, help=one.about
        )
    told = one.about + (f"  [default: {one.default_text}]" if one.default_text else "")
    shown = not is_flag or one.off is not None
    shows = shown and one.default_text is None and one.default not in (None, ())
    return _Option(
        [*names, one.name], type=None if is_flag else kind, is_flag=is_flag,
        multiple=one.many and not is_flag, required=one.required, default=_shown(one),
        show_default=shows, help=told or None, metavar=one.shown, envvar=one.variable,
        show_envvar=one.variable is not None, hidden=one.hidden, **more,
    )  # fmt: skip


def _shown(one: Field) -> Any:
    """Return the default as click takes it, which shows it."""
    return None if one.default in (None, ()) else one.default


def _flag(spelling: str, name: str, text: str) -> click.Option:
    return click.Option([spelling, name], is_flag=True, help=text)


def _note_motors(
    ctx: click.Context, _param: click.Parameter, value: tuple[str, ...]
) -> tuple[str, ...]:
    ctx.meta["motors"] = value
    return value


def _note_motor(
    ctx: click.Context, param: click.Parameter, value: tuple[str, ...]
) -> tuple[str, ...]:
    return _note_motors(ctx, param, _one_motor(value))


def _one_motor(value: tuple[str, ...]) -> tuple[str, ...]:
    """Refuse a second --motor of a command that takes one, which click would take alone."""
    if len(value) > 1:
        raise UserError(f"--motor {' --motor '.join(value)}: this command takes one motor")
    return value


def _note_machine(ctx: click.Context, _param: click.Parameter, value: str | None) -> str | None:
    ctx.meta["machine"] = value
    return value


class _ConsolePage:
    """A page on the stream that is free for words."""

    def __init__(self, output: Path | None, words: failures.OptionNames):
        self._output, self._words = output, words
        self._tell = teller(output)

    def tell(self, text: str) -> None:
        """Print a line, which names options."""
        self._tell(told(text, self._words))

    def draw(self, what: Any, *, wide: bool = False) -> None:
        """Print a table or another thing of rich's."""
        self._console(wide=wide).print(what, markup=False)

    def print(self, what: Any, /, **how: Any) -> None:
        """Print something by rich's console."""
        self._console().print(what, **how)

    def _console(self, *, wide: bool = False) -> rich.console.Console:
        from pixstep.simulation.report import NARROWEST, WIDE, new_console

        narrowest = WIDE if wide else NARROWEST
        return new_console(narrowest=narrowest, stderr=atomic.is_stdout(self._output))

    def styled(self, text: str, *, colour: str | None = None, bold: bool | None = None) -> str:
        """Return a text as a terminal shows it in a colour, or bold."""
        return click.style(text, fg=colour, bold=bold)


def _run(**_params: Any) -> None:
    """Run the operation of the command line, and print what it gives back."""
    ctx = click.get_current_context()
    asked: tuple[Request, Facts, dict[str, Source]] = ctx.meta[_ASKED]
    request, facts, sources = asked
    as_json = bool(ctx.params.get("as_json"))
    outputs = [path for _, path in perform.outputs(request)]
    page = _ConsolePage(next(filter(atomic.is_stdout, outputs), None), _words(type(request)))
    desk = Desk(
        facts, sources, _sayer(type(request)), warn=_warn, progress=progress.shown,
        complain=failures.complain, view=views.of(request.words, as_json=as_json), keeps=False,
    )  # fmt: skip
    if as_json:
        desk.row = show_json_row
    else:
        desk.tell, desk.aside = page.tell, _aside
    try:
        result = perform.finish(request, desk)
    except BaseException:
        if desk.so_far is not None:
            _deliver(request, desk.so_far, page, as_json=as_json)
        raise
    if not (as_json and request.json_rows and result.told):
        _deliver(request, result, page, as_json=as_json)
    ctx.exit(result.status)


@contextlib.contextmanager
def _explained(ctx: click.Context, request: type[Request]) -> Iterator[None]:
    """Let errors name options, and the machine file if it said what is wrong."""
    try:
        yield
    except UserError as error:
        words, cure = _words(request), ""
        text = told(error, words)
        if isinstance(error, AskedError):
            text, cure = error.told(words), error.cured(words)
        error.args = (f"{text}{origins.origin(ctx, text)}{cure}",)
        raise
    except click.BadParameter as error:
        if not error.param or not origins.by_machine(ctx, error.param.name or ""):
            raise
        raise RefusedError(f"{failures.said(error)}{origins.origin(ctx)}") from None


def _words(request: type[Request]) -> failures.OptionNames:
    return failures.OptionNames({name: one.option for name, one in fields(request).items()})


def _worded(data: Any, words: failures.OptionNames) -> Any:
    """Return data whose texts name options."""
    if isinstance(data, Mapping):
        return {key: _worded(value, words) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [_worded(value, words) for value in data]
    return told(data, words) if isinstance(data, str) else data


def _sayer(request: type[Request]) -> Callable[[Iterable[str]], None]:
    """Return what prints notes, which name options."""
    return lambda notes: say(told(note, _words(request)) for note in notes)


def _aside(text: str) -> None:
    click.echo(text, err=True)


def _warn(warnings: Iterable[str]) -> None:
    for one in warnings:
        click.echo(f"warning: {one}", err=True)


def _deliver(request: Request, result: Result, page: _ConsolePage, *, as_json: bool) -> None:
    if as_json:
        show_json(_worded(result.data, _words(type(request))))
    elif result.told:
        return
    elif not isinstance(result.text, str):
        result.text(page)
    elif result.text:
        page.tell(result.text)
