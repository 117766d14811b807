"""Turns the errors of a platform file into one sentence for the user."""

import re
import tomllib
from typing import Any, Final, get_args

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from otolith.core.disk import check_lines
from otolith.core.errors import InputError, one_of

LONGEST_LINE: Final = 2_000  # characters of a line of TOML
_KINDS: Final = {
    "string_type": "a text in quotes",
    "string_too_short": "a text of at least 1 character",
    "string_too_long": "a text of at most 80 characters",
    "bool_type": "true or false",
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "tuple_type": "a list in brackets",
    "list_type": "a list in brackets",
    "mapping_type": "a table of fields",
    "dict_type": "a table of fields",
    "greater_than": "greater than {gt:g}",
    "greater_than_equal": "at least {ge:g}",
    "less_than": "less than {lt:g}",
    "less_than_equal": "at most {le:g}",
    "model_type": "a table of fields",
    "model_attributes_type": "a table of fields",
}
_MEMBERS: Final = ("float", "int", "str")  # of the union of numbers and texts


def sentence(error: ValidationError, model: type[BaseModel], source: str) -> InputError:
    """Return the most informative of pydantic's errors; a misspelt name explains a missing field."""
    details = sorted(error.errors(), key=lambda detail: detail["type"] != "extra_forbidden")
    return _one(details[0], model, source)


def toml_fields(text: str, source: str) -> dict[str, Any]:
    """Return the fields of a TOML file, given its text.

    Parameters
    ----------
    source : name of the file, for errors.

    Raises
    ------
    InputError : the text is not TOML, is nested too deeply, or has a line longer than `LONGEST_LINE`, which
        no valid file needs and which could keep the parser busy for hours.
    """
    check_lines(text.splitlines(), source, most=LONGEST_LINE)
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise InputError(f"a value in {source}", "nested too deeply", "a few levels deep") from None
    except ValueError as error:
        raise _syntax_sentence(error, text, source) from None


def _syntax_sentence(error: Exception, text: str, source: str) -> InputError:
    """Return what is wrong with the syntax, with the line quoted; `error` is tomllib's."""
    reason, _, where = str(error).partition(" (at ")
    lines = text.splitlines() or [""]
    number = re.match(r"line (\d+)", where)
    line = int(number.group(1)) if number else len(lines)
    quoted = _shown(lines[min(line, len(lines)) - 1].strip())
    return InputError(f"line {line} of {source}", quoted, f"valid TOML ({reason[:1].lower()}{reason[1:]})")


def _one(detail: ErrorDetails, model: type[BaseModel], source: str) -> InputError:
    path = [str(part) for part in detail["loc"]]
    if path and path[-1] in _MEMBERS:  # pydantic tries a number or a text as one after the other
        return InputError(f"{'.'.join(path[:-1])} in {source}", _shown(detail["input"]), "a number or a text")
    kind, context = detail["type"], detail.get("ctx", {})
    if kind == "bound":
        field = ".".join([*path, context["field"]] if context["field"] else path)
        value = _shown(detail["input"]) if context["value"] is None else context["value"]
        return InputError(f"{field} in {source}", value, context["bound"])
    field = f"{'.'.join(path)} in {source}"
    if kind == "missing":
        return InputError(field, "missing", "given")
    if kind == "extra_forbidden":
        return InputError(field, "unknown", one_of(_fields(model, path[:-1]), path[-1]))
    otherwise = f"one of {context['expected']}" if kind == "literal_error" else detail["msg"]
    return InputError(field, _shown(detail["input"]), _KINDS.get(kind, otherwise).format_map(context))


def _fields(model: type[BaseModel], path: list[str]) -> list[str]:
    """Return the names that the table at `path` may hold."""
    for part in path:
        if part not in model.model_fields:
            continue  # a name that the user gives, in a table of tables
        annotation: Any = model.model_fields[part].annotation
        choices = get_args(annotation) or (annotation,)
        model = next(c for c in choices if isinstance(c, type) and issubclass(c, BaseModel))
    return list(model.model_fields)


def _shown(value: object) -> str:
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, bool):
        return str(value).lower()
    text = repr(value) if isinstance(value, str) else str(value)
    return text if len(text) <= 60 else f"{text[:40]}…"
