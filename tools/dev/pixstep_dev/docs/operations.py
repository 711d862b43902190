# SPDX-License-Identifier: MIT
"""The generated part of docs/OPERATIONS.md: each operation with its fields and its result."""

import inspect
from collections.abc import Iterator

from pixstep.operations import catalog, machine_defaults, python
from pixstep.operations.asked import Field
from pixstep.operations.request import Request, fields
from pixstep_dev.markdown import table


def operations() -> str:
    """Return every operation as Markdown, by the words that call it."""
    return "\n\n".join(part for words in sorted(catalog.OPERATIONS) for part in _parts(words))


def _parts(words: str) -> Iterator[str]:
    request = catalog.load(words)
    yield f"### {words}"
    yield f"`ops.{python.name_of(words)}`: {catalog.OPERATIONS[words][1]}"
    rows = [_row(one) for one in fields(request).values() if not one.hidden]
    yield table(("field", "option", "takes", "default", "machine file", "what it is"), rows)
    yield f"Gives back: {_result(request)}"


def _row(one: Field) -> tuple[str, ...]:
    key = machine_defaults.key_of(one.machine) if one.machine else ""
    option = "" if one.argument else f"`{one.option}`"
    return (
        f"`{one.name}`", option, _takes(one), _default(one), f"`{key}`" if key else "", one.about,
    )  # fmt: skip


def _takes(one: Field) -> str:
    words = getattr(one.kind, "words", None)
    kind = ", ".join(f"`{word}`" for word in words) if words else one.kind.name.lower()
    low, high = getattr(one.kind, "least", None), getattr(one.kind, "most", None)
    if low is not None and high is not None:
        kind += f", {low:,} to {high:,}"
    elif low is not None:
        kind += f", {low:,} or more"
    return f"{kind}, several" if one.many else kind


def _default(one: Field) -> str:
    if one.required:
        return "needed"
    if one.default_text:
        return one.default_text
    return "" if one.default is None or one.default == () else f"`{one.default}`"


def _result(request: type[Request]) -> str:
    found = catalog.schema(request.words)
    name = found.get("$ref", "").rpartition("/")[2]
    if not name:
        return "plain data."
    about = inspect.cleandoc(found["$defs"][name]["description"]).partition("\n")[0]
    keys = ", ".join(f"`{key}`" for key in found["$defs"][name]["properties"])
    return f"{about} Keys: {keys}."
