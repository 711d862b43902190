# SPDX-License-Identifier: MIT
"""Commands of pixstep-dev that `pixstep` offers too, to those who have it: `pixstep bench`."""

import importlib
import importlib.util
from typing import Any

import click

from pixstep.errors import UserError

_PACKAGE = "pixstep_dev"


OF_DEV = ("bench",)


def have_dev() -> bool:
    """True if pixstep-dev is installed."""
    try:
        return importlib.util.find_spec(_PACKAGE) is not None
    except ModuleNotFoundError:
        return False


class _Late(click.Command):
    """Stands for a command until somebody calls it: the product needs no pixstep-dev."""

    def __init__(self, name: str, *, module: str, about: str) -> None:
        super().__init__(name, short_help=about)
        self._module, self._attribute = module, name

    def make_context(
        self,
        info_name: str | None,
        args: list[str],
        parent: click.Context | None = None,
        **extra: Any,
    ) -> click.Context:
        """Return the context of the command itself; raises UserError where it is not installed."""
        try:
            module = importlib.import_module(self._module)
        except ModuleNotFoundError as error:
            if error.name != _PACKAGE:
                raise
            raise UserError(
                f"{self.name} is part of pixstep-dev, which measures and proves pixstep; "
                "it is not installed (a clone has it)"
            ) from None
        real: click.Command = getattr(module, self._attribute)
        return real.make_context(info_name, args, parent, **extra)


ABOUT = "Measure cycles, rates, CPU share, edge errors, waits, sizes."
BENCH = _Late(
    "bench",
    module=f"{_PACKAGE}.cli.bench",
    about=ABOUT,
)
