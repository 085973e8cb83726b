"""Parameters of primitives: fields of their ``Params`` dataclass, checked when they are described."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Collection, Iterator, Mapping, Sequence
from types import NoneType, UnionType
from typing import Any, get_args, get_origin

from skiros_py.errors import DescriptionError, UnknownName
from skiros_py.ports.signals import is_unit
from skiros_py.skills.parameters.param import IT, Access, Kind, Param, ValueClass
from skiros_py.skills.parameters.values import SAMPLES, VALUE_TYPES
from skiros_py.skills.references import variables


def check_params(params: Sequence[Param], where: str) -> None:
    """Checks parameters that belong together.

    Args:
        params: The parameters.
        where: Whose they are, for messages ("of skill 'pick'").

    Raises:
        DescriptionError: One is described wrongly, or two have the same key.
        UnknownName: One has a type that there is not, or a pattern over a parameter that there is not.
    """
    keys = [param.key for param in params]
    for number, param in enumerate(params):
        texts = param.key, param.help, param.unit
        if not all(isinstance(text, str) for text in texts) or not isinstance(param.type, str | type):
            raise DescriptionError(
                f"parameter {param.key!r} {where}: its name, help and unit are texts, and its type is a text such as "
                "'number' or a class"
            )
        if param.key in keys[:number]:
            raise DescriptionError(f"two parameters {where} are called '{param.key}'")
        if isinstance(param.type, str) and not param.is_element and param.type not in VALUE_TYPES:
            known = [*VALUE_TYPES, "a class such as sk:Arm"]
            raise UnknownName("type", param.type, known, where=f"of parameter {param.key} {where}")
        for fault in _faults(param):
            raise DescriptionError(f"parameter {param.key or '(without a name)'} {where}: {fault}")
        _check_variables(param, {p.key for p in params if p.is_element}, where)


def _faults(param: Param) -> Iterator[str]:
    if not param.key or param.key == IT or "=" in param.key or param.key.strip() != param.key:
        yield f"its key must be a name, without '=' and blanks, and not '{IT}'"
    if param.access is not Access.EXCLUSIVE and param.kind is not Kind.HARDWARE:
        yield f"access is about devices, and it is {param.kind.name}"
    if param.is_element and param.length != 1:
        yield f"it is one element, so its length cannot be {param.length}"
    if param.is_element and param.unit:
        yield f"an element has no unit, so not '{param.unit}'"
    yield from () if param.is_element else _value_faults(param)
    yield from _default_faults(param)


def _value_faults(param: Param) -> Iterator[str]:
    if param.described or param.preferred or param.cost is not None or param.unique:
        yield f"where, prefer, cost and unique are about elements, and it is {param.type_name}"
    if param.kind in (Kind.HARDWARE, Kind.PLANNING):
        yield f"only an element can be {param.kind.name}, and it is {param.type_name}"
    if param.length < 0:
        yield f"its length cannot be {param.length}: 0 stands for any number of values"
    if param.length != 1 and param.type == "vector":
        yield f"a vector has any number of numbers: say type 'number' with length {param.length}"
    if param.limits is not None and param.type not in ("number", "integer"):
        yield f"limits are for numbers, and it is {param.type_name}"
    if param.unit and param.type in ("text", "boolean", "class", "pose"):
        yield f"{param.type_name} has no unit, so not '{param.unit}'"
    elif param.unit and not is_unit(param.unit):
        yield f"'{param.unit}' is no unit such as m, kg, m/s, N m, 1 (a ratio)"


def _default_faults(param: Param) -> Iterator[str]:
    if param.kind.has_default and param.default is None:
        yield f"it is {param.kind.name} and needs a default"
    elif not param.kind.has_default and param.default is not None:
        yield f"it is {param.kind.name} and cannot have a default: make it OFFLINE or CONFIG"
    elif param.default is not None:
        several = isinstance(param.default, tuple) and param.length in (0, len(param.default))
        if param.length != 1 and not several:
            count = param.length or "any number of"
            yield f"its default must be a tuple of {count} values, not {param.default!r:.100}"
        elif wrong := _wrong(param, (param.default,) if param.length == 1 else param.default):
            yield f"its default must be {wrong}, not {param.default!r:.100}"


def _wrong(param: Param, values: tuple[Any, ...]) -> str:
    """Returns what a value of the parameter is, where one of some values is none; else an empty text."""
    if not isinstance(param.type, str):
        good, says = all(isinstance(value, param.type) for value in values), f"a {param.type_name}"
    elif param.is_element:
        good, says = all(isinstance(value, str) and value for value in values), "the id of an element"
    else:
        type_ = VALUE_TYPES[param.type]
        try:
            good, says = all(bool(type_.check(value) == value) for value in values), type_.says
        except ValueError:
            return type_.says
    return "" if good else says


def _check_variables(param: Param, keys: Collection[str], where: str) -> None:
    for pattern in (*param.described, *param.preferred):
        names = variables(pattern)
        for name in names:
            if name != IT and name not in keys:
                place = f"in a pattern of parameter {param.key} {where}"
                raise UnknownName("element parameter", name, {*keys, IT}, where=place)
        if IT not in names:
            raise DescriptionError(f"parameter {param.key} {where}: its pattern {pattern} says nothing about '{IT}'")


def param(
    type_: str | ValueClass,
    help_: str,
    *,
    kind: Kind | None = None,
    default: Any = dataclasses.MISSING,
    unit: str = "",
    length: int = 1,
    limits: tuple[float, float] | None = None,
    access: Access = Access.EXCLUSIVE,
) -> Any:
    """Declares one field of a primitive's ``Params`` dataclass; see :class:`Param`.

    Without a kind, a field with a default is OFFLINE and one without is ONLINE; an OPTIONAL one defaults to None.
    """
    if kind is None:
        kind = Kind.ONLINE if default is dataclasses.MISSING else Kind.OFFLINE
    if kind is Kind.OPTIONAL and default is dataclasses.MISSING:
        default = None
    said = {"type": type_, "help": help_, "kind": kind, "unit": unit, "length": length}
    return dataclasses.field(default=default, metadata=said | {"limits": limits, "access": access})


def own_fields(class_: type) -> dict[str, dataclasses.Field[Any]]:
    """Returns the parameters that a class declares itself, apart from those of a ``Params`` in it."""
    return {key: field for key, field in vars(class_).items() if isinstance(field, dataclasses.Field)}


def params_class(class_: type, fields: Mapping[str, dataclasses.Field[Any]]) -> type:
    """Makes the ``Params`` of a class from the parameters that it declares itself and those of its base class.

    Raises:
        DescriptionError: There is a ``Params`` besides, a parameter is called as something that every run has, or its
            annotation is of another type.
    """
    hints, where = inspect.get_annotations(class_), f"of {class_.__qualname__}"
    base: Any = getattr(class_, "Params", None)
    if "Params" in vars(class_):
        raise DescriptionError(f"parameters {where}: declare them either in the class or in its Params, not in both")
    if taken := names_of_runs(class_.__mro__[1]).intersection(fields):
        raise DescriptionError(f"parameter {min(taken)} {where}: every run has something called so; choose another key")
    made = dataclasses.make_dataclass(
        "Params",
        [(key, hints.get(key, Any), field) for key, field in fields.items()],
        bases=() if base is None else (base,),
        frozen=True,
        kw_only=True,
    )
    made.__qualname__ = class_.__qualname__
    for param in params_of(made):
        if wrong := _hint_problem(class_, param):
            raise DescriptionError(f"parameter {param.key} {where}: {wrong}")
    return made


def names_of_runs(class_: type) -> set[str]:
    """Returns what no parameter that a subclass declares itself can be called: every run has something called so."""
    names = (name for one in class_.__mro__ for name in (*vars(one), *inspect.get_annotations(one)))
    return {"context", "params", "loaded", *names}


def _hint_problem(class_: type, param: Param) -> str:
    """Returns what the annotation of a parameter must be, where it is another; else an empty text."""
    try:
        hint = inspect.get_annotations(class_, eval_str=True).get(param.key, Any)
    except (NameError, TypeError, SyntaxError):
        return ""  # a type checker says what is wrong with it
    type_ = param.type if isinstance(param.type, type) else type(SAMPLES.get(param.type, ""))
    wanted = [tuple if param.length != 1 else type_, *([NoneType] if param.kind is Kind.OPTIONAL else [])]
    given = {get_origin(one) or one for one in (get_args(hint) if isinstance(hint, UnionType) else [hint])}
    right = " | ".join("None" if one is NoneType else one.__name__ for one in wanted)
    return (
        "" if given in ({*wanted}, {Any}) else f"it is {param.kind.name} and {param.type_name}: annotate it as {right}"
    )


def params_of(dataclass_type: type) -> tuple[Param, ...]:
    """Reads the parameters that a ``Params`` dataclass declares.

    Raises:
        DescriptionError: A field was not declared with :func:`param`, or is no sound parameter.
        UnknownName: A field has a type that there is not.
    """
    params = tuple(_read(dataclass_type, field) for field in dataclasses.fields(dataclass_type))
    check_params(params, f"of {dataclass_type.__qualname__}")
    return params


def _read(owner: type, field: dataclasses.Field[Any]) -> Param:
    if "help" not in field.metadata:
        raise DescriptionError(f"{owner.__qualname__}.{field.name}: declare it with param(type, help, …)")
    said = dict(field.metadata)
    default = None if field.default is dataclasses.MISSING else field.default
    return Param(field.name, said.pop("type"), said.pop("help"), default=default, **said)
