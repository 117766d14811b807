"""`otolith list`: show what is available by name."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Annotated, Any, Final

import typer
from rich.table import Table

from otolith import registry
from otolith.cli.output import print_json, screen, warn
from otolith.core.errors import InputError, one_of


def _entries(table: Mapping[str, registry.Entry]) -> dict[str, str]:
    return {name: entry.description for name, entry in table.items()}


def _platforms() -> dict[str, str]:
    from otolith.platforms.library import descriptions

    return descriptions()


def _scenarios() -> dict[str, str]:
    from otolith.scenarios import FAMILIES, SCENARIOS
    from otolith.scenarios.catalog import family_parameters

    described = {name: entry.description for name, entry in SCENARIOS.items()}
    for name, family in FAMILIES.items():
        shown = {k: v for k, v in family_parameters(name).items() if k not in {"waves", "axis"}}
        described[f"{name}:…"] = f"{family.description}; {_assignments(shown)}"
    return described


def _roads() -> dict[str, str]:
    from otolith.core.formula import defaults
    from otolith.vehicle import ROADS

    parameters = {name: _assignments(defaults(road.build)) for name, road in ROADS.items()}
    return {
        name: road.description + (f"; {parameters[name]}" if parameters[name] else "")
        for name, road in ROADS.items()
    }


def _assignments(values: Mapping[str, Any]) -> str:
    return ",".join(f"{key}={value}" for key, value in values.items())


# What can be listed, and how the names with their descriptions are found; nothing is imported for the others.
KINDS: Final[Mapping[str, Callable[[], dict[str, str]]]] = {
    "cueing": partial(_entries, registry.CUEING),
    "plants": partial(_entries, registry.PLANTS),
    "solvers": partial(_entries, registry.SOLVERS),
    "perception": partial(_entries, registry.PERCEPTION),
    "platforms": _platforms,
    "scenarios": _scenarios,
    "roads": _roads,
}


def _shadowed(kind: str) -> dict[str, str]:
    """Return names that other distributions declare but that are already taken."""
    table = {"cueing": registry.CUEING, "plants": registry.PLANTS}.get(kind)
    return {} if table is None else table.shadowed()


def list_(
    kind: Annotated[
        str,
        typer.Argument(
            metavar="KIND", help="cueing, perception, plants, platforms, roads, scenarios, solvers."
        ),
    ],
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")] = False,
) -> None:
    """List cueing algorithms, perception models, plants, platforms, roads, scenarios or solvers."""
    if kind not in KINDS:
        raise InputError("KIND", repr(kind), one_of(sorted(KINDS), kind))
    described = KINDS[kind]()
    if json:
        print_json(described)
        return
    for name, other in _shadowed(kind).items():
        warn(screen(), f"{name!r} of {other} is left out, for the name is taken")
    table = Table(box=None, pad_edge=False)
    table.add_column(kind, no_wrap=True, style="bold")
    table.add_column("what it is")
    for name, description in described.items():
        table.add_row(name, description)
    screen(stderr=False).print(table, markup=False)
