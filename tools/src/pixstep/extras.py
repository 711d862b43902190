# SPDX-License-Identifier: MIT
"""What an installation may lack: packages that a part of pixstep needs, and the extra of each."""

import importlib.util

from pixstep.errors import UserError

# The package: what needs it, and the extra that brings it (pyproject.toml).
_EXTRAS = {
    "numpy": ("this needs numpy", "numpy"),
    "matplotlib": ("drawings need matplotlib", "plot"),
    "pyarrow": ("Parquet needs pyarrow", "parquet"),
}


class MissingPackageError(UserError):
    """A package is not installed that an extra of pixstep brings."""


def have(package: str) -> bool:
    """True if a package of the extras is installed; it is not loaded."""
    try:
        return importlib.util.find_spec(package) is not None
    except ValueError:  # its import is barred: there is no such module
        return False


def require(package: str) -> None:
    """Raise MissingPackageError if a package of the extras is not installed."""
    if not have(package):
        raise _missing(package)


def of_import(error: ModuleNotFoundError) -> MissingPackageError | None:
    """Return what an import's error means if it is a package of the extras that is missing."""
    package = (error.name or "").partition(".")[0]
    return _missing(package) if package in _EXTRAS else None


def _missing(package: str) -> MissingPackageError:
    need, extra = _EXTRAS[package]
    return MissingPackageError(f"{need}: pip install 'pixstep[{extra}]'")
