"""What is wrong with a field, in sentences for people: a type checker's own words are for programmers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_WORDS = {
    "bool": "must be true or false",
    "int": "must be a whole number",
    "int_from_float": "must be a whole number",
    "float": "must be a number",
    "decimal": "must be a number",
    "finite_number": "must be a finite number",
    "string": "must be text",
    "list": "must be a list",
    "tuple": "must be a list",
    "dict": "must be an object with named fields",
    "mapping": "must be an object with named fields",
    "model": "must be an object with named fields",
    "model_attributes": "must be an object with named fields",
    "none_required": "must be null",
    "missing": "is missing",
    "extra_forbidden": "is not known here",
    "greater_than_equal": "must be at least {ge}",
    "greater_than": "must be more than {gt}",
    "less_than_equal": "must be at most {le}",
    "less_than": "must be less than {lt}",
    "string_too_short": "must have at least {min_length} characters",
    "string_too_long": "must have at most {max_length} characters",
    "string_pattern_mismatch": "must be written as {pattern}",
    "too_short": "must have at least {min_length} entries",
    "too_long": "must have at most {max_length} entries",
    "literal_error": "must be {expected}",
    "enum": "must be {expected}",
    "json_invalid": "is not JSON: {error}",
}
"""By kind of fault, as pydantic names them; what is only of the wrong type has one entry for all ways to find that."""
_NONE = "must not be empty"
_LIMITS = ("ge", "gt", "le", "lt", "min_length", "max_length")


def fault_words(fault: Mapping[str, Any]) -> str:
    """Returns what is wrong, to be read after the name of the field.

    Args:
        fault: One of the errors of a ``pydantic.ValidationError``.
    """
    kind, context = str(fault["type"]), {name: _plain(value) for name, value in fault.get("ctx", {}).items()}
    if context.get("min_length") == 1:  # whether signs or entries are lacking
        return _NONE
    words = _WORDS.get(kind) or _WORDS.get(kind.removesuffix("_type").removesuffix("_parsing"))
    if words is None:
        return str(fault["msg"]).removeprefix("Value error, ")
    try:
        return words.format(**context)
    except LookupError:
        return str(fault["msg"])


def _plain(value: object) -> object:
    """Writes whole numbers without a point."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def fault_limit(fault: Mapping[str, Any]) -> float | int | None:
    """Returns the bound that is broken; None where there is none."""
    context = fault.get("ctx", {})
    return next((context[name] for name in _LIMITS if isinstance(context.get(name), int | float)), None)
