"""Recorded drives in JSON: an array of records, one record per line, or an object of arrays.

Records may be nested and hold vectors: ``{"linear_accel": [1, 2, 9.8]}`` gives ``linear_accel.x`` to ``.z``.
If a document holds several tables, each keeps its own clock, and its name precedes those of its columns.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.recordings.cells import numbers, read_stamps
from otolith.recordings.channels import Layout
from otolith.recordings.columns import Header, candidates
from otolith.recordings.recorded import Cells, Columns

MAX_TEXT: Final = 64 * 2**20  # characters; a parsed document takes about ten times this memory
MAX_DEPTH: Final = 8
MAX_COLUMNS: Final = 2000
FORM: Final = 'a table of records, such as [{"t": 0.0, "ax": 0.1}, …], of one record a line, or of arrays'
Record = Mapping[str, Any]


def looks_like_json(text: str) -> bool:
    """Return whether a text begins as JSON does; a bracket alone may begin a section of another format."""
    start = text.lstrip("\ufeff \t\r\n")[:200]
    return start.startswith("{") or (start.startswith("[") and start[1:].lstrip()[:1] in ("{", "[", '"'))


def parse_json(text: str, source: str) -> Columns:
    """Read the columns of a JSON document or of JSON lines.

    Raises
    ------
    InputError : the text is not JSON, is too large, holds no table, or holds several tables of which none has
        a time.
    """
    if len(text) > MAX_TEXT:
        bound = f"at most {MAX_TEXT // 2**20} million characters; write longer drives as CSV"
        raise InputError(f"size of {source}", f"{len(text) / 2**20:.0f} million characters", bound)
    form, document = _loaded(text, source)
    tables = {name: table for name, table in _tables(document, "", 0) if len(table) > 1}
    if isinstance(document, dict) and str(document.get("type", "")).startswith("Feature"):
        raise InputError(source, "GeoJSON, a way without time or forces", FORM)
    if not tables:
        raise InputError(source, "JSON without a table", FORM)
    read = {name: _columns(table) for name, table in tables.items()}
    if len(read) == 1:
        [columns] = read.values()
        return _one(columns, source, form, len(next(iter(tables.values()))))
    return _several(read, source, form)


def _loaded(text: str, source: str) -> tuple[str, Any]:
    try:
        return "JSON", json.loads(text)
    except json.JSONDecodeError as error:
        lines = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip()]
        fault = error
    except RecursionError:
        raise InputError(source, "JSON nested too deeply", FORM) from None
    if len(lines) < 2 or not all(line.lstrip()[:1] == "{" for _, line in lines[:2]):
        where = f"line {fault.lineno} of {source}"
        raise InputError(where, f"no JSON ({fault.msg})", FORM) from None
    records = []
    for number, line in lines:
        try:
            records.append(json.loads(line))
        except (json.JSONDecodeError, RecursionError) as error:
            where = f"line {number} of {source}"
            raise InputError(where, f"no JSON ({error})", "one record, as the lines before") from None
    return "JSON, one record a line", records


def _tables(value: Any, name: str, depth: int) -> Iterator[tuple[str, Sequence[Record]]]:
    """Yield all tables in a document, each with its path: lists of records, and objects of arrays."""
    if depth > MAX_DEPTH:
        return
    if isinstance(value, list):
        if value and all(isinstance(one, dict) for one in value):
            yield from _by_sensor(value, name)
        elif len(value) > 1 and _is_header(value[0]) and all(isinstance(one, list) for one in value):
            yield name, [dict(zip(value[0], row, strict=False)) for row in value[1:]]
    elif isinstance(value, dict):
        arrays = {k: v for k, v in value.items() if isinstance(v, list) and v and not isinstance(v[0], dict)}
        lengths = {len(array) for array in arrays.values()}
        if len(arrays) > 1 and len(lengths) == 1:
            yield name, [dict(zip(arrays, row, strict=True)) for row in zip(*arrays.values(), strict=True)]
            return
        for key, inner in value.items():
            yield from _tables(inner, f"{name} {key}".strip(), depth + 1)


def _by_sensor(records: list[Record], name: str) -> Iterator[tuple[str, Sequence[Record]]]:
    """Yield the records of one kind, or split records of several kinds by the name of their sensor."""
    key = next((k for k in ("sensor", "topic", "type", "stream") if isinstance(records[0].get(k), str)), None)
    kinds = {str(record.get(key)) for record in records} if key else set()
    if key is None or len(kinds) < 2:
        yield name, records
        return
    for kind in sorted(kinds):
        yield f"{name} {kind}".strip(), [record for record in records if str(record.get(key)) == kind]


def _is_header(row: Any) -> bool:
    return isinstance(row, list) and bool(row) and all(isinstance(cell, str) for cell in row)


def _columns(records: Sequence[Record]) -> dict[str, Cells]:
    """Turn records into columns by name; a value that a record lacks is blank."""
    found: dict[str, list[Any]] = {}
    for row, record in enumerate(records):
        for name, value in _flat(record, "", 0):
            if name not in found and len(found) < MAX_COLUMNS:
                found[name] = [None] * row
            if name in found:
                found[name].append(value)
        for column in found.values():
            if len(column) <= row:
                column.append(None)
    return {name: _cells(column) for name, column in found.items() if len(column) == len(records)}


def _flat(value: Any, name: str, depth: int) -> Iterator[tuple[str, Any]]:
    if isinstance(value, dict) and depth < MAX_DEPTH:
        for key, inner in value.items():
            yield from _flat(inner, f"{name}.{key}" if name else str(key), depth + 1)
    elif isinstance(value, list):
        if len(value) <= 4 and all(isinstance(one, int | float) for one in value):
            for place, one in enumerate(value):
                yield f"{name}.{'xyz'[place] if len(value) == 3 else place}", one
    else:
        yield name, value


def _cells(column: list[Any]) -> Cells:
    """Return numbers, also where they are written as texts; otherwise texts."""
    if all(one is None or isinstance(one, int | float) for one in column):
        return np.array([np.nan if one is None else float(one) for one in column])
    texts = ["" if one is None else str(one) for one in column]
    values, wrong = numbers(texts)
    return texts if wrong is not None else values


def _one(columns: Mapping[str, Cells], source: str, form: str, rows: int) -> Columns:
    return Columns(
        source=source,
        names=tuple(columns),
        units=("",) * len(columns),
        values=tuple(columns.values()),
        layout=Layout(form=form, rows=rows),
        place="record",
    )


def _several(read: Mapping[str, Mapping[str, Cells]], source: str, form: str) -> Columns:
    """Combine tables with clocks of their own into one set of columns."""
    names: list[str] = []
    values: list[Cells] = []
    clocks: list[Vec] = []
    for table, columns in read.items():
        one = _one(columns, source, form, 0)
        found = candidates(Header(source, one.names, one.units), {})
        if not found.get("t"):
            continue
        t = read_stamps(one, found["t"][0])
        for name, cells in columns.items():
            if name != found["t"][0].name and isinstance(cells, np.ndarray):
                names.append(f"{table} {name}")
                values.append(cells)
                clocks.append(t.t + t.zero)
    if not names:
        raise InputError(source, f"JSON of {len(read)} tables without time", FORM)
    return Columns(
        source=source,
        names=tuple(names),
        units=("",) * len(names),
        values=tuple(values),
        clocks=tuple(clocks),
        layout=Layout(form=f"{form}, {len(read)} tables"),
        place="record",
        notes=(f"{source}: {len(read)} tables, each on its own clock",),
    )
