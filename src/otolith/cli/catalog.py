"""`otolith list`: show what is available by name."""

from collections.abc import Mapping
from typing import Annotated

import typer
from rich.table import Table

from otolith import registry
from otolith.cli.options import warn
from otolith.cli.output import print_json, screen
from otolith.core.errors import InputError, one_of
from otolith.core.formula import defaults
from otolith.platforms import catalog, load
from otolith.scenarios import FAMILIES, SCENARIOS
from otolith.scenarios.catalog import family_parameters
from otolith.vehicle import ROADS


def _shadowed(kind: str) -> dict[str, str]:
    """Return names that other distributions declare but that are already taken."""
    table = {"cueing": registry.CUEING, "plants": registry.PLANTS}.get(kind)
    return {} if table is None else table.shadowed()


def _tables() -> dict[str, dict[str, str]]:
    entries: dict[str, Mapping[str, registry.Entry]] = {
        "cueing": registry.CUEING,
        "plants": registry.PLANTS,
        "solvers": registry.SOLVERS,
        "perception": registry.PERCEPTION,
    }
    described = {kind: {name: e.description for name, e in table.items()} for kind, table in entries.items()}
    described["platforms"] = {name: load(name).description for name in catalog()}
    described["scenarios"] = {name: entry.description for name, entry in SCENARIOS.items()}
    for name, family in FAMILIES.items():
        parameters = ",".join(
            f"{key}={value}" for key, value in family_parameters(name).items() if key not in {"waves", "axis"}
        )
        described["scenarios"][f"{name}:…"] = f"{family.description}; {parameters}"
    described["roads"] = {}
    for name, road in ROADS.items():
        parameters = ",".join(f"{key}={value}" for key, value in defaults(road.build).items())
        described["roads"][name] = road.description + (f"; {parameters}" if parameters else "")
    return described


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
    tables = _tables()
    if kind not in tables:
        raise InputError("KIND", repr(kind), one_of(sorted(tables), kind))
    if json:
        print_json(tables[kind])
        return
    for name, other in _shadowed(kind).items():
        warn(screen(), f"{name!r} of {other} is left out, for the name is taken")
    table = Table(box=None, pad_edge=False)
    table.add_column(kind, no_wrap=True, style="bold")
    table.add_column("what it is")
    for name, description in tables[kind].items():
        table.add_row(name, description)
    screen(stderr=False).print(table, markup=False)
