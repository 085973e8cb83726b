"""Values of an author's own Python class: checked, read and written as pydantic does it.

pydantic is imported when the first such value is met: the command line must start quickly.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from skiros_py.errors import DescriptionError
from skiros_py.skills.parameters.param import ValueClass
from skiros_py.skills.parameters.value_types import ValueType

if TYPE_CHECKING:
    from pydantic import TypeAdapter, ValidationError

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
