"""Fills in templates: replaces placeholders in structured conditions by names, which are never parsed as syntax."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from skiros_py.api.goals import Material
from skiros_py.api.templates import GoalTemplateContent
from skiros_py.errors import UnknownName, UsageError

_FIELDS = ("class", "definition", "id", "location", "lot", "use")
"""The fields of a material that a placeholder may refer to."""
_MOST = 2000
"""Maximum number of conditions that a template may produce."""
_LARGEST = 5000
"""Maximum total number of names, lists and objects in a template."""
_MOST_MADE = 20_000
"""The same for the result of filling it in."""
_DEEPEST = 60


def filled(
    name: str, template: GoalTemplateContent, parameters: Mapping[str, str], materials: Sequence[Material]
) -> list[Any]:
    """Returns the structured conditions of a template filled in with an order.

    Args:
        name: Its name, for messages.
        template: Its content.
        parameters: The parameters of the order, by name.
        materials: The materials of the order.

    Raises:
        UnknownName: The template has no such parameter.
        UsageError: A parameter is missing, or the material does not fit.
    """
    values = _values(name, template, parameters)
    goal = [_replaced(one, values, {}) for one in template.goal]
    if template.per_material is None:
        if materials:
            raise UsageError(f"materials: goal template '{name}' says nothing of materials; leave them out")
        return goal
    _check_number(name, template.per_material, materials)
    pieces = [_replaced(template.per_material, values, piece) for piece in _pieces(materials)]
    _check_pieces(name, pieces)
    return goal + pieces


def faults_of(template: GoalTemplateContent) -> list[str]:
    """Returns the faults in the placeholders of a template, one sentence each, with its path."""
    size = _size([*template.goal, template.per_material])
    if size > _LARGEST:
        return [f"goal: a template has {_LARGEST} names, lists and objects at most, this one has {size}"]
    names = [parameter.name for parameter in template.parameters]
    twice = sorted({name for name in names if names.count(name) > 1})
    faults = [f"parameters: '{name}' is there twice" for name in twice]
    for index, goal in enumerate(template.goal):
        faults += _faults(goal, f"goal[{index}]", names, ())
    if template.per_material is not None:
        faults += _faults(template.per_material, "per_material", names, _FIELDS)
    if not template.goal and template.per_material is None:
        faults.append("goal: a template needs conditions, or one for each material")
    return faults


def _values(name: str, template: GoalTemplateContent, parameters: Mapping[str, str]) -> dict[str, str]:
    known = {parameter.name: parameter.default for parameter in template.parameters}
    for given in parameters:
        if given not in known:
            raise UnknownName("parameter", given, known, where=f"of goal template '{name}'")
    values = {key: parameters.get(key, default) for key, default in known.items()}
    missing = [key for key, value in values.items() if value is None]
    if missing:
        raise UsageError(f"parameters: goal template '{name}' needs {', '.join(missing)}")
    return {key: value for key, value in values.items() if value is not None}


def _pieces(materials: Sequence[Material]) -> Iterator[dict[str, str]]:
    """Yields each single piece of the order."""
    for material in materials:
        fields = material.model_dump(by_alias=True)
        for _ in range(material.pieces):
            yield {field: fields[field] for field in _FIELDS}


def _check_number(name: str, condition: object, materials: Sequence[Material]) -> None:
    """Checks that the material does not produce too many conditions, before producing any."""
    number = sum(material.pieces for material in materials)
    if number > _MOST:
        raise UsageError(f"materials: more than {_MOST} pieces in one order")
    if number * _size(condition) > _MOST_MADE:
        raise UsageError(
            f"materials: goal template '{name}' is too large for {number} pieces in one order; for"
            f" {_MOST_MADE // _size(condition)} it will do"
        )


def _size(data: object) -> int:
    """Returns the number of names, lists and objects in the data."""
    number, left = 0, [data]
    while left:
        number += 1
        one = left.pop()
        left.extend(one.values() if isinstance(one, dict) else one if isinstance(one, list | tuple) else ())
    return number


def _check_pieces(name: str, pieces: list[Any]) -> None:
    """Checks that each piece has its own condition: two identical ones would be fulfilled by one piece."""
    if not pieces:
        raise UsageError(f"materials: goal template '{name}' makes a condition of each material, and none is ordered")
    seen: set[str] = set()
    for piece in pieces:
        if (text := repr(_without_prefixes(piece))) in seen:
            raise UsageError(
                f"materials: two pieces lead to the same condition {text[:200]}, which one of them would fulfil:"
                " give each an id or a location of its own, and a template that uses it"
            )
        seen.add(text)


def _without_prefixes(data: Any) -> Any:
    """Returns data with names without prefixes: "Starter" and "kitting:Starter" are the same class."""
    match data:
        case str():
            return data.rpartition(":")[2]
        case dict():
            return {key: _without_prefixes(value) for key, value in data.items()}
        case list():
            return [_without_prefixes(value) for value in data]
        case _:
            return data


def _replaced(data: Any, parameters: Mapping[str, str], material: Mapping[str, str]) -> Any:
    """Returns data with placeholders replaced by names."""
    match data:
        case {"parameter": str(key)} if len(data) == 1:
            return parameters[key]
        case {"material": str(field)} if len(data) == 1:
            if not material[field]:
                raise UsageError(f"materials: the goal template needs the {field} of each material")
            return material[field]
        case dict():
            return {key: _replaced(value, parameters, material) for key, value in data.items()}
        case list():
            return [_replaced(value, parameters, material) for value in data]
        case _:
            return data


def _faults(data: Any, path: str, names: Sequence[str], fields: Sequence[str], depth: int = 0) -> list[str]:
    if depth > _DEEPEST:
        return [f"{path[:200]}: nested deeper than {_DEEPEST} levels"]
    match data:
        case {"parameter": key} if len(data) == 1:
            return [] if key in names else [f"{path}: {UnknownName('parameter', str(key), names)}"]
        case {"material": field} if len(data) == 1:
            where = "" if fields else "(materials are for per_material only)"
            unknown = UnknownName("field of a material", str(field), fields, where=where)
            return [] if field in fields else [f"{path}: {unknown}"]
        case dict():
            each = [_faults(value, f"{path}.{key}", names, fields, depth + 1) for key, value in data.items()]
        case list():
            each = [_faults(value, f"{path}[{i}]", names, fields, depth + 1) for i, value in enumerate(data)]
        case _:
            return []
    return [fault for found in each for fault in found]
