"""What values a parameter takes that is no element: how each type is checked, read and written."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from skiros_py.geometry import Pose
from skiros_py.world.literals import DATATYPES


@dataclass(frozen=True, slots=True)
class ValueType:
    """One type of values.

    Attributes:
        says: What a value is, for messages.
        check: Returns the value in its own form, or raises ValueError where it is none.
        parse: Reads a text, as it stands on a command line.
        text: Writes it as such a text.
        json: Writes it as plain data.
        schema: JSON schema of that data.
    """

    says: str
    check: Callable[[Any], Any]
    parse: Callable[[str], Any]
    text: Callable[[Any], str] = str
    json: Callable[[Any], Any] = field(default=lambda value: value)
    schema: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))


def _check_number(value: Any) -> float:
    """A whole number stays one: an author may count with it."""
    checked = DATATYPES["xsd:double"].check(value)
    return value if type(value) is int else float(checked)  # type: ignore[arg-type]  # it is a number


def _parse_number(text: str) -> Any:
    try:
        return DATATYPES["xsd:integer"].parse(text)
    except ValueError:
        return DATATYPES["xsd:double"].parse(text)


def _check_pose(value: Any) -> Any:
    """A pose, or the six numbers that it is written with."""
    if isinstance(value, Pose):
        return DATATYPES["sk:poseLiteral"].check(value)
    numbers = DATATYPES["sk:vectorLiteral"].check(value)
    return DATATYPES["sk:poseLiteral"].parse(DATATYPES["sk:vectorLiteral"].format(numbers))


def _pose_numbers(pose: Pose) -> list[float]:
    return [float(word) for word in DATATYPES["sk:poseLiteral"].format(pose).split()]


def _of(curie: str, says: str, schema: str) -> ValueType:
    datatype = DATATYPES[curie]
    return ValueType(says, datatype.check, datatype.parse, datatype.format, schema={"type": schema})


_NUMBERS: Mapping[str, Any] = MappingProxyType({"type": "array", "items": {"type": "number"}})

VALUE_TYPES: Mapping[str, ValueType] = MappingProxyType(
    {
        "number": ValueType("a finite number", _check_number, _parse_number, repr, schema={"type": "number"}),
        "integer": _of("xsd:integer", "a whole number", "integer"),
        "text": _of("xsd:string", "a text", "string"),
        "boolean": _of("xsd:boolean", "true or false", "boolean"),
        "pose": ValueType(
            'a pose "x y z roll pitch yaw" of finite numbers [m, rad]',
            _check_pose,
            DATATYPES["sk:poseLiteral"].parse,
            DATATYPES["sk:poseLiteral"].format,
            _pose_numbers,
            {**_NUMBERS, "minItems": 6, "maxItems": 6},
        ),
        "vector": ValueType(
            "finite numbers separated by blanks",
            DATATYPES["sk:vectorLiteral"].check,
            DATATYPES["sk:vectorLiteral"].parse,
            DATATYPES["sk:vectorLiteral"].format,
            list,
            _NUMBERS,
        ),
        "class": _of("xsd:string", "the name of a class", "string"),
    }
)
"""By the name that a parameter gives."""
