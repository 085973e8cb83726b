"""The value of one parameter: read from Python, JSON or a command line, checked by its type, and written again."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from skiros_py.errors import DescriptionError, UnknownName, UsageError
from skiros_py.geometry import Pose
from skiros_py.messages import Message, joined
from skiros_py.skills.parameters.param import Kind, Param, ValueClass
from skiros_py.world.element import Value
from skiros_py.world.literals import CLASS_NAME, DATATYPES, format_value, shown
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import ELEMENT

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
        sample: An example; None for a Python class.
    """

    says: str
    check: Callable[[Any], Any]
    parse: Callable[[str], Any]
    text: Callable[[Any], str] = str
    json: Callable[[Any], Any] = field(default=lambda value: value)
    schema: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    sample: Any = None


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
    return DATATYPES["sk:poseLiteral"].parse(format_value(numbers))


def _pose_numbers(pose: Pose) -> list[float]:
    return [float(word) for word in format_value(pose).split()]


def _of(curie: str, says: str, schema: Mapping[str, Any], sample: Any, **other: Callable[[Any], Any]) -> ValueType:
    datatype = DATATYPES[curie]
    usual: dict[str, Any] = {"check": datatype.check, "parse": datatype.parse, "text": format_value}
    return ValueType(says, schema=MappingProxyType(schema), sample=sample, **(usual | other))


_NUMBER: Mapping[str, Any] = {"type": "number"}
_NUMBERS: Mapping[str, Any] = {"type": "array", "items": _NUMBER}
_POSE = Message('a pose "x y z roll pitch yaw" of finite numbers [m, rad]')
_SIX = {**_NUMBERS, "minItems": 6, "maxItems": 6}

VALUE_TYPES: Mapping[str, ValueType] = MappingProxyType(
    {
        "number": ValueType(Message("a finite number"), _check_number, _parse_number, repr, schema=_NUMBER, sample=1.0),
        "integer": _of("xsd:integer", Message("a whole number"), {"type": "integer"}, 1),
        "text": _of("xsd:string", Message("a text"), {"type": "string"}, "text"),
        "boolean": _of("xsd:boolean", Message("true or false"), {"type": "boolean"}, True),
        "pose": _of("sk:poseLiteral", _POSE, _SIX, Pose(), check=_check_pose, json=_pose_numbers),
        "vector": _of(
            "sk:vectorLiteral", Message("finite numbers separated by blanks"), _NUMBERS, (1.0, 1.0), json=list
        ),
        "class": _of("xsd:string", Message("the name of a class"), {"type": "string"}, ELEMENT),
    }
)
"""By the name that a parameter gives."""
SAMPLES: Mapping[str, Any] = MappingProxyType({name: type_.sample for name, type_ in VALUE_TYPES.items()})
"""An example of each."""


def sample_of_range(range_: str) -> Value | None:
    """Returns an example value of a property range; None if there is none."""
    datatype, own = DATATYPES[range_], SAMPLES["class"] if range_ == CLASS_NAME else None
    return own or next((datatype.check(one) for one in (*SAMPLES.values(), "[]") if datatype.fits(one)), None)


@cache
def custom_type(class_: ValueClass) -> ValueType:
    """Returns how values of a Python class are checked, read and written.

    Raises:
        DescriptionError: pydantic does not know how to.
    """
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


def _listed(value: Any) -> list[Any] | None:
    return list(value) if isinstance(value, set | frozenset) else None


def _checked(adapter: TypeAdapter[Any], value: object) -> Any:
    from pydantic import ValidationError

    try:
        checked = adapter.validate_python(value)
    except ValidationError as error:
        raise ValueError(_says(error)) from None
    try:
        json.dumps(adapter.dump_python(checked), allow_nan=False, skipkeys=True, default=_listed)
    except ValueError:
        raise ValueError("every number in it must be finite") from None
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


def read_value(param: Param, value: Any, view: WorldView, noun: str = "parameter") -> Any:
    """Checks a value of a parameter and returns it in its own form.

    Args:
        param: The parameter.
        value: A Python value, plain data as JSON has it, or a text as it stands on a command line ("0.5", "1 2 3").
        view: Where elements and classes are looked up.
        noun: What messages call it: a parameter, or an output.

    Raises:
        UnknownName: There is no such element or class.
        UsageError: It is no value of that parameter; the message says what would be.
    """
    if param.is_element:
        return _element(param, value, view, f"{noun} {param.key}")
    read = read_constant(param, value, noun)
    if param.type != "class":
        return read
    resolve = view.ontology.resolve_class
    return tuple(map(resolve, read)) if isinstance(read, tuple) else resolve(read)


def read_constant(param: Param, value: Any, noun: str = "parameter") -> Any:
    """Checks a value of a parameter that is no element, without a world; see :func:`read_value`.

    Raises:
        UsageError: It is no value of that parameter; the message says what would be.
    """
    try:
        return _one(param, value) if param.length == 1 else _several(param, value)
    except (ValueError, RecursionError) as error:
        raise UsageError(refusal(param, value, noun, str(error))) from None


def as_text(param: Param, value: Any) -> str:
    """Returns a value as a text that :func:`read_value` reads again."""
    if value is None or param.is_element:
        return "" if value is None else str(value)
    if param.length == 1:
        return _type_of(param).text(value)
    if param.type in ("number", "integer", "boolean"):
        return " ".join(_type_of(param).text(one) for one in value)
    return json.dumps(as_json(param, value))


def as_json(param: Param, value: Any) -> Any:
    """Returns a value as plain data that :func:`read_value` reads again."""
    if value is None or param.is_element:
        return value
    written = _type_of(param).json
    return written(value) if param.length == 1 else [written(one) for one in value]


def as_shown(param: Param, value: Any) -> Any:
    """Returns a value as plain data to be shown; a value that cannot be read is shown as it was given."""
    try:
        return as_json(param, value)
    except (TypeError, ValueError, AttributeError):
        return str(value)


def schema(param: Param) -> dict[str, Any]:
    """Returns the JSON schema of a parameter's value: what a form shows of it and allows.

    Of an element it says the class (``class``), of a number the unit (``unit``); ``kind`` is the parameter's kind.
    """
    said: dict[str, Any] = {"title": param.key, "description": param.help, "kind": param.kind.value}
    one = {} if param.is_element else dict(_type_of(param).schema)
    if param.limits is not None:
        one["minimum"], one["maximum"] = param.limits
    if param.is_element:
        said |= {"type": "string", "class": param.element_class}
    elif param.length == 1:
        said = {**one, **said}
    else:
        said |= {"type": "array", "items": one}
        said |= {"minItems": param.length, "maxItems": param.length} if param.length else {}
    if param.unit:
        said["unit"] = param.unit
    if param.default is not None:
        said["default"] = as_json(param, param.default)
    return said


def _type_of(param: Param) -> ValueType:
    return VALUE_TYPES[param.type] if isinstance(param.type, str) else custom_type(param.type)  # type: ignore[arg-type]


def _one(param: Param, value: Any) -> Any:
    type_ = _type_of(param)
    if isinstance(value, str) and param.type not in ("text", "class"):
        value = json.loads(value) if param.type in VALUE_TYPES and _is_json(value) else type_.parse(value)
    checked = type_.check(value)
    if param.limits is not None and not param.limits[0] <= checked <= param.limits[1]:
        raise ValueError(f"it must be between {param.limits[0]:g} and {param.limits[1]:g}")
    return checked


def _several(param: Param, value: Any) -> tuple[Any, ...]:
    if isinstance(value, str):
        value = json.loads(value) if _is_json(value) else value.split()
    if not isinstance(value, list | tuple):
        raise ValueError
    if param.length and len(value) != param.length:
        raise ValueError(f"it has {len(value)}")
    return tuple(_one(param, one) for one in value)


def _is_json(text: str) -> bool:
    return text.lstrip()[:1] in ("[", "{")


def refusal(param: Param, value: Any, noun: str = "parameter", why: str = "") -> str:
    """Returns the message that a value is none of a parameter, or an output, of such a type."""
    says = Message("a {kind}", kind=param.element_class) if param.is_element else _type_of(param).says
    if param.length:
        says = says if param.length == 1 else Message("{count} values, each {wanted}", count=param.length, wanted=says)
    else:
        says = Message("any number of values, each {wanted}", wanted=says)
    if param.unit:
        says = joined(" ", (says, f"[{param.unit}]"))
    text = Message(
        "{noun} {key} takes {wanted}, not {given}", noun=noun, key=param.key, wanted=says, given=shown(value)
    )
    return joined(": ", (text, why)) if why else text


def _element(param: Param, value: Any, view: WorldView, what: str) -> str:
    class_ = param.element_class
    if not isinstance(value, str):
        raise UsageError("{what} takes the id of a {kind}, not {given}", what=what, kind=class_, given=shown(value))
    name = value if view.has(value) else _labelled(param, value, view, what)
    type_ = view.element(name).type
    if not view.ontology.is_a(type_, class_):
        names = view.instances(class_)
        things = ", ".join(names[:20]) + (", …" if len(names) > 20 else "")
        there = Message("There are {things}.", things=things) if names else Message("There is none.")
        raise UsageError(
            "{what} takes a {kind}, and {thing} is a {other}. {hint}",
            what=what,
            kind=class_,
            thing=name,
            other=type_,
            hint=there,
        )
    return name


def _labelled(param: Param, label: str, view: WorldView, what: str) -> str:
    """The one element of the parameter's class that is called so."""
    names = view.instances(param.element_class)
    found = [name for name in names if view.element(name).label == label]
    if len(found) == 1:
        return found[0]
    if found:
        raise UsageError(
            "{what}: {things} are all called {label}: say which",
            what=what,
            things=", ".join(found[:20]),
            label=shown(label),
        )
    raise UnknownName(
        "element", label, names, where=Message("for {what}, a {kind}", what=what, kind=param.element_class)
    )


Arguments = Mapping[str, Any]
"""Value by key of every parameter; None where it is not specified."""


def read_arguments(
    params: Sequence[Param], given: Mapping[str, Any], view: WorldView, noun: str = "parameter"
) -> Arguments:
    """Checks the values given for a call, and adds the defaults.

    Args:
        params: The parameters.
        given: Values by key: from Python, from JSON, or texts of a command line; None is like left out.
        view: Where elements and classes are looked up.
        noun: What messages call them: parameters, or outputs.

    Raises:
        UnknownName: The one thing wrong is an unknown parameter, element or class.
        UsageError: Something in them is wrong; with several things the message says each.
    """
    faults: list[UsageError] = []
    by_key = {param.key: param for param in params}
    values = {param.key: param.default for param in params}
    for key, value in given.items():
        if value is None and key in by_key:
            continue
        try:
            if key not in by_key:
                raise UnknownName(noun, key, by_key)
            if by_key[key].kind is Kind.CONFIG:
                raise UsageError(
                    "parameter {key} is fixed when the module is loaded: it cannot be given at a call", key=key
                )
            values[key] = read_value(by_key[key], value, view, noun)
        except UsageError as fault:
            faults.append(fault)
    if len(faults) > 1:
        raise UsageError("; ".join(str(fault).rstrip(".") for fault in faults))
    if faults:
        raise faults[0]
    return values


def missing(params: Iterable[Param], values: Mapping[str, Any]) -> tuple[str, ...]:
    """Returns the keys of required parameters that are not specified: a module does not run before all are."""
    return tuple(param.key for param in params if param.kind.is_required and values.get(param.key) is None)
