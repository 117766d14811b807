"""A function of C that a kernel becomes, and its parameters."""

from dataclasses import dataclass, field
from itertools import count
from typing import Any

from otolith.export.translate.values import Kind, Storage, Value

_serial = count()


@dataclass(eq=False)
class Parameter:
    """A parameter of a C function."""

    name: str
    kind: Kind
    storage: Storage | None = None  # of an array
    used: bool = True


@dataclass(eq=False)
class Function:
    """A kernel, translated for arguments of one kind."""

    name: str
    comment: str
    parameters: list[Parameter]  # one for every part of the arguments that is not known
    returns: Kind | tuple[Kind, ...] | None = None
    constant: tuple[Value] | None = None  # what it returns, if it does nothing else
    body: Any = None
    calls: set[int] = field(default_factory=set)  # serials of the functions that it calls
    variables: dict[str, Any] = field(default_factory=dict)
    reads: set[int] = field(default_factory=set)  # serials of the data that it names
    serial: int = field(default_factory=lambda: next(_serial))
