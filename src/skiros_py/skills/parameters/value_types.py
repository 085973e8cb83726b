"""What values a parameter takes that is no element: how each type is checked, read and written."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from skiros_py.errors import DescriptionError
from skiros_py.geometry import Pose
from skiros_py.skills.parameters.param import ValueClass
from skiros_py.world.literals import DATATYPES

if TYPE_CHECKING:
    from pydantic import TypeAdapter, ValidationError


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

_TYPES: dict[ValueClass, ValueType] = {}


def custom_type(class_: ValueClass) -> ValueType:
    """Returns how values of a Python class are checked, read and written.

    Raises:
        DescriptionError: pydantic does not know how to.
    """
    if class_ not in _TYPES:
        _TYPES[class_] = _made(class_)
    return _TYPES[class_]


def _made(class_: ValueClass) -> ValueType:
    from pydantic import TypeAdapter
    from pydantic.errors import PydanticUserError

    try:
        adapter: TypeAdapter[Any] = TypeAdapter(class_)
        schema = adapter.json_schema()
    except (PydanticUserError, NameError) as error:
        text = str(error).splitlines()[0]
        raise DescriptionError(f"parameter type {class_.__name__}: it cannot be written as JSON: {text}") from error
    return ValueType(
        says=f"a {class_.__name__}",
        check=lambda value: _checked(adapter, value),
        parse=lambda text: _parsed(adapter, text),
        text=lambda value: adapter.dump_json(value).decode(),
        json=lambda value: adapter.dump_python(value, mode="json"),
        schema=schema,
    )


def _checked(adapter: TypeAdapter[Any], value: object) -> Any:
    from pydantic import ValidationError

    try:
        checked = adapter.validate_python(value)
    except ValidationError as error:
        raise ValueError(_says(error)) from None
    if not all(math.isfinite(number) for number in _numbers(adapter.dump_python(checked))):
        raise ValueError("every number in it must be finite")
    return checked


def _parsed(adapter: TypeAdapter[Any], text: str) -> Any:
    """Reads JSON; the bare word of an Enum or of a text will do, too."""
    from pydantic import ValidationError

    try:
        return adapter.validate_python(text)
    except ValidationError as as_word:
        try:
            return adapter.validate_json(text)
        except ValidationError as as_json:
            raise ValueError(_says(as_json if text.lstrip()[:1] in ("{", "[") else as_word)) from None


def _says(error: ValidationError) -> str:
    """The first few faults, each with where it is."""
    faults = error.errors(include_url=False, include_context=False)[:3]
    return "; ".join(f"{'.'.join(map(str, f['loc']))}: {f['msg']}".removeprefix(": ") for f in faults)


def _numbers(data: object) -> Iterator[float]:
    if isinstance(data, float):
        yield data
    elif isinstance(data, Mapping):
        for value in data.values():
            yield from _numbers(value)
    elif isinstance(data, tuple | list | set | frozenset):
        for value in data:
            yield from _numbers(value)
