# SPDX-License-Identifier: MIT
"""JSON schemas of what operations give back: of their results' types, which say everything."""

from __future__ import annotations

import inspect
import types
import typing
from typing import Any, NotRequired, get_args, get_origin, get_type_hints, is_typeddict

from pixstep.operations import catalog

DIALECT = "https://json-schema.org/draft/2020-12/schema"
_PLAIN = {
    int: {"type": "integer"},
    float: {"type": "number"},
    str: {"type": "string"},
    bool: {"type": "boolean"},
    type(None): {"type": "null"},
    Any: {},
    object: {},
}


def all_schemas() -> dict[str, Any]:
    """Return one document: the result of each operation by its words, beside what is shared."""
    shared: dict[str, Any] = {}
    results = {
        words: _of(catalog.load(words).result, shared) for words in sorted(catalog.OPERATIONS)
    }
    return {"$schema": DIALECT, "properties": results, "$defs": dict(sorted(shared.items()))}


def schema(words: str) -> dict[str, Any]:
    """Return the schema of one operation's result."""
    shared: dict[str, Any] = {}
    return {"$schema": DIALECT, **_of(catalog.load(words).result, shared), "$defs": shared}


def _of(kind: Any, shared: dict[str, Any]) -> dict[str, Any]:
    if kind in _PLAIN:
        return dict(_PLAIN[kind])
    if is_typeddict(kind):
        return _of_dict(kind, shared)
    origin, inner = get_origin(kind), get_args(kind)
    if origin in (typing.Union, types.UnionType):
        return {"anyOf": [_of(one, shared) for one in inner]}
    if origin is typing.Literal:
        return {"enum": list(inner)}
    if origin in (list, tuple) or getattr(origin, "__name__", "") == "Sequence":
        return {"type": "array", "items": _of(inner[0], shared) if inner else {}}
    if origin is dict or getattr(origin, "__name__", "") == "Mapping":
        return {"type": "object", "additionalProperties": _of(inner[1], shared)}
    if kind is dict:
        return {"type": "object"}
    raise TypeError(f"{kind}: no part of a result")


def _of_dict(kind: Any, shared: dict[str, Any]) -> dict[str, Any]:
    name = kind.__name__
    if name not in shared:
        shared[name] = {}  # stands there already where the type has itself inside
        hints = get_type_hints(kind, include_extras=True)
        needed = [key for key, hint in hints.items() if get_origin(hint) is not NotRequired]
        shared[name] = {
            "type": "object",
            "description": inspect.getdoc(kind) or "",
            "properties": {key: _of(_bare(hint), shared) for key, hint in hints.items()},
            "required": [key for key in needed if key in kind.__required_keys__],
            "additionalProperties": False,
        }
    return {"$ref": f"#/$defs/{name}"}


def _bare(hint: Any) -> Any:
    return get_args(hint)[0] if get_origin(hint) is NotRequired else hint
