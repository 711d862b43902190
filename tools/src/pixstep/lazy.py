# SPDX-License-Identifier: MIT
"""Packages that are loaded when they are first used, and what an installation may lack of them.

A command's help, and a command that does without them, need not wait for numpy or rich: modules
have `np`, `pyarrow` and the others from here. A package that one module alone needs is there so:

    if TYPE_CHECKING:
        import distributed
    else:
        distributed = lazy("distributed")
"""

import importlib
import importlib.util
from types import ModuleType
from typing import TYPE_CHECKING, Any

from pixstep.errors import UserError

_LOADED = "__loaded__"
_MISSING = object()
_CLONE = " (in a clone: tools/setup)"
# The package: what needs it, and the extra that brings it (pyproject.toml).
_EXTRAS = {
    "numpy": ("this needs numpy", "numpy"),
    "matplotlib": ("drawings need matplotlib", "plot"),
    "pyarrow": ("Parquet needs pyarrow", "parquet"),
    "distributed": ("a Dask cluster needs distributed", "cluster"),
    "useq": ("a useq-schema sequence needs useq-schema", "scans"),
    "yaml": ("a useq-schema sequence in YAML needs PyYAML", "scans"),
    "caproto": ("EPICS needs caproto", "epics"),
    "bluesky": ("fly scans need bluesky", "bluesky"),
    "scanspec": ("scans need scanspec", "bluesky"),
}


class MissingPackageError(UserError):
    """A package is not installed that an extra of pixstep brings."""


def have_package(package: str) -> bool:
    """True if a package of the extras is installed; it is not loaded."""
    try:
        return importlib.util.find_spec(package) is not None
    except ValueError:  # its import is barred: there is no such module
        return False


def require_package(package: str) -> None:
    """Raise MissingPackageError if a package of the extras is not installed."""
    if not have_package(package):
        raise _missing(package)


def missing_package(error: ModuleNotFoundError) -> MissingPackageError | None:
    """Return what an import's error means if it is a package of the extras that is missing."""
    package = (error.name or "").partition(".")[0]
    return _missing(package) if package in _EXTRAS else None


def _missing(package: str) -> MissingPackageError:
    need, extra = _EXTRAS[package]
    return MissingPackageError(f"{need}: pip install 'pixstep[{extra}]'{_CLONE}")


class _Lazy(ModuleType):
    """Stands for a module."""

    def __getattr__(self, name: str) -> Any:
        # Looked up here each time, as nothing of it is kept: only the module is.
        module = self.__dict__.get(_LOADED)
        if module is None:
            try:
                module = self.__dict__[_LOADED] = importlib.import_module(self.__name__)
            except ModuleNotFoundError as error:
                raise missing_package(error) or error from None
        found = getattr(module, name, _MISSING)
        if found is not _MISSING:
            return found
        try:
            return importlib.import_module(f"{self.__name__}.{name}")  # a package's own module
        except ModuleNotFoundError:
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}") from None


def lazy(name: str) -> ModuleType:
    """Return what stands for a module of this name."""
    return _Lazy(name)


if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    import pyarrow
    import rich.box
    import rich.console
    import rich.rule
    import rich.table
    from pyarrow import parquet
else:
    np, npt, rich = lazy("numpy"), lazy("numpy.typing"), lazy("rich")
    pyarrow, parquet = lazy("pyarrow"), lazy("pyarrow.parquet")

__all__ = [
    "MissingPackageError", "have_package", "lazy", "missing_package", "np", "npt", "parquet",
    "pyarrow", "require_package", "rich",
]  # fmt: skip
