# SPDX-License-Identifier: MIT
"""Modules that take long to load: imported when something of them is first used.

A command's help, and a command that does without them, need not wait for numpy or rich:

    if TYPE_CHECKING:
        import numpy as np
    else:
        np = lazy("numpy")
"""

import importlib
from types import ModuleType
from typing import Any

from pixstep import extras

_LOADED = "__loaded__"
_MISSING = object()


class _Lazy(ModuleType):
    """Stands for a module."""

    def __getattr__(self, name: str) -> Any:
        # Looked up here each time, as nothing of it is kept: only the module is.
        module = self.__dict__.get(_LOADED)
        if module is None:
            module = self.__dict__[_LOADED] = self._load()
        found = getattr(module, name, _MISSING)
        if found is not _MISSING:
            return found
        try:
            return importlib.import_module(f"{self.__name__}.{name}")  # a package's own module
        except ModuleNotFoundError:
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}") from None

    def _load(self) -> ModuleType:
        try:
            return importlib.import_module(self.__name__)
        except ModuleNotFoundError as error:
            raise extras.of_import(error) or error from None


def lazy(name: str) -> ModuleType:
    """Return what stands for a module of this name."""
    return _Lazy(name)
