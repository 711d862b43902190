# SPDX-License-Identifier: MIT
"""The click types of the kinds of values: what click itself knows is left to it."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

import click

from pixstep.cli import command
from pixstep.errors import UserError
from pixstep.operations import kinds


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
