"""Behaviours as plain data, and back: what documents are stored as."""

from __future__ import annotations

import enum
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import MISSING, Field, dataclass, field, fields, is_dataclass
from functools import cache
from inspect import formatannotation
from types import MappingProxyType, NoneType, UnionType
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

from skiros_py.errors import DescriptionError, SkirosError, UnknownName
from skiros_py.skills import conditions as patterns
from skiros_py.skills.behaviour import Behaviour, Out, P
from skiros_py.skills.conditions import Condition, ConditionType, all_of, any_of, exists, for_all, holds
from skiros_py.skills.conditions.compound import Junction, Quantified
from skiros_py.skills.conditions.expression import ExpressionCondition

B = TypeVar("B")

_PATTERNS: Mapping[str, type[Any]] = {
    name: getattr(patterns, name)
    for name in (
        "AllOf", "AnyOf", "ClassRelated", "Compare", "Computed", "Exists", "Expression", "Has", "IsA", "Not", "Nothing",
        "Related",
    )
}  # fmt: skip


def fields_as_data(thing: Any) -> dict[str, Any]:
    """Returns the fields of a dataclass as plain data, without those that have their defaults.

    Raises:
        DescriptionError: It is no dataclass, or a value cannot be written down.
    """
    found = {}
    for one in _fields(type(thing)).values():
        default = one.default_factory() if one.default_factory is not MISSING else one.default
        value = getattr(thing, one.name)
        if default is MISSING or type(value) is not type(default) or value != default:
            found[one.name] = as_data(value)
    return found


def _fields(cls: type) -> dict[str, Field[Any]]:
    if not is_dataclass(cls):
        raise DescriptionError(f"{cls.__name__}: define to_data() and from_data(), or make it a dataclass")
    return {one.name: one for one in fields(cls) if one.init}


def as_data(value: Any) -> Any:
    """Returns a value of a behaviour as plain data that JSON can carry.

    Raises:
        DescriptionError: It cannot be written down.
    """
    match value:
        case enum.Enum():
            return value.value
        case None | bool() | int() | float() | str():
            return value
        case Behaviour():
            return value.to_data()
        case P():
            return {"P": value.key}
        case Out():
            return {"Out": value.name}
        case Condition():
            return _condition(value)
        case Mapping():
            return {str(key): as_data(one) for key, one in value.items()}
        case list() | tuple():
            return [as_data(one) for one in value]
        case _ if type(value).__name__ in _PATTERNS and isinstance(value, _PATTERNS[type(value).__name__]):
            return {"$pattern": type(value).__name__, **fields_as_data(value)}
        case _:
            raise DescriptionError(f"{value!r:.100} cannot be written down as data")


def _condition(condition: Condition) -> dict[str, Any]:
    said: dict[str, Any] = {"not": True} if condition.negated else {}
    if condition.name is not None:
        said["name"] = condition.name
    match condition:
        case Junction():
            return {**said, condition.word: [as_data(part) for part in condition.parts]}
        case ExpressionCondition():
            return {**said, "expression": str(condition)}
        case Quantified():
            ranges = {"variable": condition.variable, "class": condition.class_}
            return {**said, condition.quantifier: as_data(condition.part), **ranges}
        case _:
            return {**said, "condition": condition.type.name, "arguments": list(condition.arguments)}


@dataclass(frozen=True)
class Reader:
    """Reads behaviours from plain data; messages name the place of a fault ("children[1].module").

    Attributes:
        kinds: Kinds of behaviour by name.
        words: Conditions by word.
        places: Where each behaviour that was read stands, by its ``id()``.
    """

    kinds: Mapping[str, type[Behaviour]]
    words: Mapping[str, ConditionType] = field(default_factory=dict)
    places: dict[int, str] = field(default_factory=dict, init=False)
    _place: list[str] = field(default_factory=list, init=False)

    @property
    def place(self) -> str:
        """Where in the data it reads now."""
        return "".join(self._place).lstrip(".")

    @contextmanager
    def at(self, step: str | int) -> Iterator[None]:
        """Goes one step into the data, for messages."""
        self._place.append(f"[{step}]" if isinstance(step, int) else f".{step}")
        yield
        self._place.pop()  # not after an error: messages name the innermost place

    def behaviour(self, data: Any, place: str = "") -> Behaviour:
        """Reads a behaviour.

        Args:
            data: The behaviour as plain data.
            place: Where it stands in its document ("body").

        Raises:
            DescriptionError: Something in it is wrong; the error has the place.
        """
        self._place[:] = [place]
        try:
            value = self.value(data)
            if not isinstance(value, Behaviour):
                raise DescriptionError("a node with a type, such as {'type': 'wait', 'seconds': 1}")
        except SkirosError as error:
            raise DescriptionError(str(error), self.place) from error
        except (TypeError, ValueError, RecursionError) as error:
            raise DescriptionError(f"{type(error).__name__}: {error}", self.place) from error
        return value

    def dataclass(self, cls: type[B], data: Mapping[str, Any]) -> B:
        """Makes a dataclass of its fields as plain data.

        Raises:
            DescriptionError: A field is missing, not known, or wrong.
        """
        known = _fields(cls)
        given = {key: value for key, value in data.items() if key not in ("type", "$pattern")}
        for key in given:
            if key not in known:
                raise UnknownName("field", key, known)
        open_ = [k for k, f in known.items() if k not in given and f.default is f.default_factory is MISSING]
        if open_:
            raise DescriptionError(f"it has no {' and no '.join(open_)}")
        values = {key: self.field(key, value) for key, value in given.items()}
        made, hints = cls(**values), _hints(cls)  # type: ignore[arg-type]  # a class is hashable
        for key, value in values.items():
            with self.at(key):
                if not _fits(value, hints.get(key)):
                    raise DescriptionError(f"it must be {formatannotation(hints[key])}, not {given[key]!r:.100}")
        return made

    def field(self, key: str, data: Any) -> Any:
        """Reads the value of a field."""
        with self.at(key):
            return self.value(data)

    def value(self, data: Any) -> Any:
        """Reads a value: a constant, a behaviour, a condition, a pattern, or several of them."""
        if isinstance(data, Mapping):
            return self._tagged(data)
        if isinstance(data, Sequence) and not isinstance(data, str):
            found = []
            for index, one in enumerate(data):
                with self.at(index):
                    found.append(self.value(one))
            return tuple(found)
        return data

    def _tagged(self, data: Mapping[str, Any]) -> Any:
        match data:
            case {"type": str(kind)}:
                if kind not in self.kinds:
                    raise UnknownName("kind of behaviour", kind, self.kinds)
                made = self.kinds[kind].from_data(data, self)
                self.places[id(made)] = self.place
                return made
            case {"P": str(key)} if len(data) == 1:
                return P(key)
            case {"Out": str(name)} if len(data) == 1:
                return Out(name)
            case {"$pattern": str(name)}:
                if name not in _PATTERNS:
                    raise UnknownName("pattern", name, _PATTERNS)
                return self.dataclass(_PATTERNS[name], data)
            case {"condition": _} | {"expression": _} | {"and": _} | {"or": _} | {"for all": _} | {"exists": _}:
                found = ~self._positive(data) if data.get("not") else self._positive(data)
                return found.named(str(data["name"])) if data.get("name") else found
            case _:
                return MappingProxyType({key: self.field(key, value) for key, value in data.items()})

    def _positive(self, data: Mapping[str, Any]) -> Condition:
        match data:
            case {"condition": str(word), "arguments": arguments}:
                if word not in self.words:
                    raise UnknownName("condition", word, self.words)
                return self.words[word](*arguments)
            case {"expression": str(text)}:
                return holds(text)
            case {"and": parts}:
                return all_of(*self.field("and", parts))
            case {"or": parts}:
                return any_of(*self.field("or", parts))
            case {"for all": part, "variable": variable, "class": class_}:
                return for_all(variable, class_, self.field("for all", part))
            case {"exists": part, "variable": variable, "class": class_}:
                return exists(variable, class_, self.field("exists", part))
            case _:
                raise DescriptionError("no condition, such as {'condition': 'InKit', 'arguments': ['Part', 'Kit']}")


@cache
def _hints(cls: type) -> Mapping[str, Any]:
    """Returns the types of a dataclass's fields; none where they name what is imported for type checkers only."""
    try:
        return get_type_hints(cls)
    except (NameError, AttributeError, TypeError):
        return {}


def _fits(value: Any, hint: Any) -> bool:
    """Tells whether a value is of a field's type, as far as that is plain, a behaviour, or made of such ones."""
    parts = get_args(hint)
    if get_origin(hint) in (Union, UnionType):
        return any(_fits(value, part) for part in parts)
    if get_origin(hint) is tuple and isinstance(value, tuple) and parts:
        expected = parts[:1] * len(value) if parts[1:] == (...,) else parts
        return len(value) == len(expected) and all(map(_fits, value, expected))
    if hint in (int, float):
        return isinstance(value, int | hint) and not isinstance(value, bool)
    if hint in (str, bool, NoneType, P, Out) or (isinstance(hint, type) and issubclass(hint, Behaviour)):
        return isinstance(value, hint)
    return get_origin(hint) is not tuple
