"""Arguments of a builder from text, ``amplitude=0.7,frequency=0.2``, checked against its defaults."""

import inspect
from collections.abc import Callable
from typing import Any

from otolith.core.errors import InputError, one_of

Builder = Callable[..., Any]


def defaults(build: Builder) -> dict[str, Any]:
    """Those parameters of a builder that fit in a text, numbers and words, with their defaults."""
    parameters = inspect.signature(build).parameters.values()
    return {p.name: p.default for p in parameters if isinstance(p.default, int | float | str)}


def arguments(text: str, name: str, build: Builder) -> dict[str, Any]:
    """What a text sets of the parameters of `build`; `name` is the builder's in error sentences.

    Raises
    ------
    InputError : unknown parameter, one given twice or without a value, a value of another kind.
    """
    known = defaults(build)
    values: dict[str, Any] = {}
    for part in filter(None, (piece.strip() for piece in text.split(","))):
        key, equals, value = (piece.strip() for piece in part.partition("="))
        if not known:
            raise InputError(f"parameter of {name}", repr(key), "left out: it has none")
        if key not in known:
            raise InputError(f"parameter of {name}", repr(key), one_of(known, key))
        if not equals or key in values:
            raise InputError(f"parameter of {name}", repr(part), f"given once, as {key}={known[key]}")
        values[key] = _value(key, value, type(known[key]))
    return values


def _value(key: str, text: str, kind: type) -> Any:
    words = {int: "a whole number", float: "a number", str: "a word"}
    try:
        return kind(text)
    except ValueError:
        raise InputError(key, repr(text), words[kind]) from None
