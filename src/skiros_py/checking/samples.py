"""Values for what nobody says: of each type one that is as good as any."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from skiros_py.geometry import Pose
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.element import Value
from skiros_py.world.literals import DATATYPES
from skiros_py.world.vocabulary import ELEMENT

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
    """Returns a value that a property of that range may have; None where none comes to mind."""
    for value in _OF_TYPE.values():
        try:
            return DATATYPES[range_].check(value)
        except ValueError:
            continue
    return None
