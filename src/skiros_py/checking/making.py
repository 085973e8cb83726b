"""Generates a world in which a skill can start: adds missing elements, and makes its preconditions hold."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from skiros_py.geometry import Pose
from skiros_py.skills.conditions import AllOf, Has, Pattern, Related, write_effects
from skiros_py.skills.lint.rules.reach import brought_about
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.element import Placement, Value
from skiros_py.world.literals import DATATYPES
from skiros_py.world.terms import Family
from skiros_py.world.transaction import Transaction
from skiros_py.world.vocabulary import ELEMENT, FLOOR, ON, SPATIAL_THING
from skiros_py.world.world import World


def make_up(description: SkillDescription, world: World, given: Mapping[str, Any]) -> dict[str, Any]:
    """Adds an element for each element parameter not given, and makes the preconditions hold as far as possible.

    Returns:
        Value by key of every parameter.

    Raises:
        WorldError: The world does not allow it.
    """
    values: dict[str, Any] = {param.key: param.default for param in description.params} | dict(given)
    with world.transaction("contract test", f"prepares where {description.name} can start") as tx:
        for param in description.params:
            if param.is_element and values[param.key] is None and param.kind.is_required:
                values[param.key] = _added(tx, param, world, is_piece=_is_piece(param.key, description, world))
        for condition in description.needs:
            bound = condition.bind(values)
            write_effects(tx, world.ontology, brought_about(bound))
            _give(tx, bound.pattern, world)
    return values


def _added(tx: Transaction, param: Param, world: World, *, is_piece: bool) -> str:
    is_spatial = world.ontology.is_a(param.element_class, SPATIAL_THING)
    floor = Placement(ON, world.instances(FLOOR)[0]) if is_spatial and not is_piece else None
    return tx.add(param.element_class, placement=floor)


def _is_piece(key: str, description: SkillDescription, world: World) -> bool:
    """Returns whether a precondition makes it a piece of another element, so that it has no place of its own."""
    return any(
        isinstance(p, Related) and p.object == key and world.ontology.family(p.relation) is Family.STRUCTURE
        for p in (condition.pattern for condition in description.needs)
    )


def _give(tx: Transaction, pattern: Pattern, world: World) -> None:
    """Sets a required property of an element."""
    match pattern:
        case Has(property_, subject) if world.ontology.class_value(tx.view.element(subject).type, property_) is None:
            value = sample_of_range(world.ontology.properties[property_].range)
            if tx.view.value(subject, property_) is None and value is not None:
                tx.set(subject, property_, value)
        case AllOf(patterns):
            for part in patterns:
                _give(tx, part, world)
        case _:
            pass


# ---------------------------------------------------------------- default values


_OF_TYPE: Mapping[str, Any] = MappingProxyType(
    {
        "number": 1.0,
        "integer": 1,
        "text": "text",
        "boolean": True,
        "pose": Pose(),
        "vector": (1.0,),
        "class": ELEMENT,
    }
)


def sample_values(description: SkillDescription) -> dict[str, Any]:
    """Returns a value for each parameter that must be given and cannot be inferred."""
    return {
        param.key: _sample(param)
        for param in description.params
        if param.kind is Kind.ONLINE and not param.is_element and param.type in _OF_TYPE
    }


def _sample(param: Param) -> Any:
    one = _OF_TYPE[str(param.type)]
    return one if param.length == 1 else (one,) * max(1, param.length)


def sample_of_range(range_: str) -> Value | None:
    """Returns an example value of a property range; None if there is none."""
    for value in _OF_TYPE.values():
        try:
            return DATATYPES[range_].check(value)
        except ValueError:
            continue
    return None
