"""The short notation for parameters and conditions: ``Part:sk:Manipulatable``, ``Scanned(Part)``."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from skiros_py.errors import UnknownName, UsageError
from skiros_py.scaffold.spelling import sentence, words_of
from skiros_py.skills.parameters import Kind
from skiros_py.world.ontology import Ontology

VALUE_TYPES: Mapping[str, str] = {
    "number": "float",
    "integer": "int",
    "text": "str",
    "boolean": "bool",
}
"""Python type by the type of a parameter that is a value."""

_UNITS = {"seconds": "s", "metres": "m", "radians": "rad", "newtons": "N", "kilograms": "kg", "degrees": "deg"}
_PARAMETER = re.compile(r"(?P<key>[^:=\[]*):(?P<type>[^=\[]+?)(=(?P<default>[^\[]*?))?\s*(\[(?P<unit>[^\]]*)\])?")
_WANTED = re.compile(r"(?P<not>not\s+)?(?P<word>[A-Za-z]\w*)\s*\(\s*(?P<arguments>[^()]*)\)")


@dataclass(frozen=True, slots=True)
class Declared:
    """One parameter as its author declared it.

    Attributes:
        key: Its name.
        type: CURIE of an element class, or one of :data:`VALUE_TYPES`.
        help: One sentence for people.
        kind: The kind of the parameter, which determines who specifies it.
        default: Value if it is not specified; None for none.
        unit: Unit of a number; "1" for one without.
    """

    key: str
    type: str
    help: str
    kind: Kind = Kind.ONLINE
    default: Any = None
    unit: str = ""

    @property
    def is_element(self) -> bool:
        """True when its value is the id of an element."""
        return ":" in self.type


@dataclass(frozen=True, slots=True)
class Wanted:
    """A condition as its author wrote it."""

    word: str
    arguments: tuple[str, ...]
    negated: bool = False

    def __str__(self) -> str:
        return f"{'not ' if self.negated else ''}{self.word}({', '.join(self.arguments)})"


def read_parameter(text: str, ontology: Ontology) -> Declared:
    """Reads ``KEY:TYPE``, ``KEY:TYPE=DEFAULT`` or ``KEY:TYPE=DEFAULT [UNIT]``, then perhaps ``-- HELP``.

    Raises:
        UsageError: The text has a different form.
        UnknownName: No ontology declares the class.
    """
    said, _, help_ = text.partition(" -- ")
    match = _PARAMETER.fullmatch(said.strip())
    if match is None:
        raise UsageError(f"parameter '{text}': write KEY:TYPE, such as Part:sk:Object or 'seconds:number=1.0 [s]'")
    key, type_ = match["key"].strip(), match["type"].strip()
    if not key.isidentifier() or not key.isascii() or len(key) > 40:
        raise UsageError(f"parameter '{text}': '{key}' is no name for a parameter: letters, digits and '_'")
    if type_ in VALUE_TYPES:
        return _value(key, type_, match["default"], match["unit"], help_)
    if match["default"] is not None or match["unit"] is not None:
        raise UsageError(f"parameter '{text}': an element has neither default nor unit")
    class_ = _class(type_, key, ontology)
    return Declared(key, class_, _help(help_, f"The {words_of(key)}", key), kind_of(class_, ontology))


def kind_of(class_: str, ontology: Ontology) -> Kind:
    """Returns the kind of a parameter of an element class: devices are chosen, robots follow from them."""
    if ontology.is_a(class_, "sk:Robot"):
        return Kind.PLANNING
    hardware = any(ontology.is_a(class_, above) for above in ("sk:Device", "sk:Agent"))
    return Kind.HARDWARE if hardware else Kind.ONLINE


def _class(type_: str, key: str, ontology: Ontology) -> str:
    try:
        return ontology.resolve_class(type_)
    except UnknownName as error:
        known = [*ontology.classes, *VALUE_TYPES]
        raise UnknownName("class or type", type_, known, where=f"of parameter '{key}'") from error


def _value(key: str, type_: str, default: str | None, unit: str | None, help_: str) -> Declared:
    if unit is not None and type_ not in ("number", "integer"):
        raise UsageError(f"parameter '{key}': a {type_} has no unit")
    own = unit or (_UNITS.get(key, "1") if type_ in ("number", "integer") else "")
    said = _help(help_, f"{'How many' if own not in ('', '1') else 'The'} {words_of(key)}", key)
    if default is None:
        return Declared(key, type_, said, Kind.ONLINE, None, own)
    return Declared(key, type_, said, Kind.OFFLINE, _read(f"parameter '{key}'", type_, default.strip()), own)


def _read(what: str, type_: str, text: str) -> Any:
    if type_ == "text":
        return text
    if type_ == "boolean" and text.lower() in ("true", "false"):
        return text.lower() == "true"
    if type_ != "boolean":
        try:
            number = float(text) if type_ == "number" else int(text)
        except ValueError:
            number = float("inf")
        if abs(number) < float("inf"):
            return number
    raise UsageError(f"{what}: '{text}' is no {type_}")


def _help(text: str, default: str, key: str) -> str:
    return sentence(text or default, f"help of parameter '{key}'")


def read_wanted(text: str) -> Wanted:
    """Reads ``Scanned(Part)`` or ``not Scanned(Part)``.

    Raises:
        UsageError: The text has a different form.
    """
    match = _WANTED.fullmatch(text.strip())
    if match is None:
        raise UsageError(f"condition '{text}': write a word and parameters, such as 'RobotAtLocation(Robot, Station)'")
    arguments = tuple(argument.strip() for argument in match["arguments"].split(","))
    return Wanted(match["word"], arguments, match["not"] is not None)


def read_constant(text: str, range_: str, what: str) -> bool | int | float | str:
    """Parses a value of the data type of a property.

    Raises:
        UsageError: It is not such a value, or values of that type cannot be compared.
    """
    types = {"xsd:boolean": "boolean", "xsd:integer": "integer", "xsd:string": "text", "sk:className": "text"}
    type_ = types.get(range_, "number" if range_ in ("xsd:decimal", "xsd:double", "xsd:float") else "")
    if not type_:
        raise UsageError(f"{what}: values of type {range_} are not compared; leave it out to ask whether there is one")
    value: bool | int | float | str = _read(what, type_, text)
    return value
