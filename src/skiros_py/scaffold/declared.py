"""Names in generated code, and the short notation for parameters: ``Part:sk:Manipulatable``."""

from __future__ import annotations

import keyword
import re
from collections.abc import Mapping
from typing import Any

from skiros_py.errors import UnknownName, UsageError
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.parameters.values import VALUE_TYPES
from skiros_py.world.literals import CLASS_NAME, parse_value
from skiros_py.world.ontology import Ontology

_LONGEST = 40
_LONGEST_SENTENCE = 100
_MODULE = re.compile(r"[a-z][a-z0-9_]*")
_CLASS = re.compile(r"[A-Z][A-Za-z0-9]*")
_EDGE = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])|[^A-Za-z0-9]+")


def module_name(name: str, what: str) -> str:
    """Checks the name of something that becomes a Python module ("read_code").

    Raises:
        UsageError: It is not valid; the text suggests a similar one.
    """
    return _checked(name, what, _MODULE, snake_case(name), "a name of small letters, digits and '_'")


def class_name(name: str, what: str) -> str:
    """Checks the name of something that is written in capitals and joined words ("RobotAtLocation").

    Raises:
        UsageError: It is not valid; the text suggests a similar one.
    """
    return _checked(name, what, _CLASS, joined(name), "a name of letters and digits that begins with a capital")


def _checked(name: str, what: str, shape: re.Pattern[str], near: str, form: str) -> str:
    if not shape.fullmatch(name):
        hint = f", such as '{near}'" if shape.fullmatch(near) and not keyword.iskeyword(near) else ""
        raise UsageError(f"{what} '{name[:80]}': {form}{hint}")
    if keyword.iskeyword(name):
        raise UsageError(f"{what} '{name}': that is a word of Python itself; choose another")
    if len(name) > _LONGEST:
        raise UsageError(f"{what} '{name[:_LONGEST]}…': {_LONGEST} letters at most")
    return name


def sentence(text: str, what: str) -> str:
    """Turns a text into one sentence: a capital at the start, a full stop at the end.

    Raises:
        UsageError: It is empty, too long for a line, or contains invalid characters.
    """
    text = text.strip()
    if not text or len(text) > _LONGEST_SENTENCE:
        raise UsageError(f"{what}: one sentence of 1 to {_LONGEST_SENTENCE} letters, not {len(text)}")
    if not text.isprintable() or "\\" in text or '"' in text:
        raise UsageError(f"{what}: one line without '\\' and '\"', not {text!r}")
    return text[0].upper() + text[1:] + ("" if text[-1] in ".!?" else ".")


def words_of(name: str) -> str:
    """Returns a name as people write it: "RobotAtLocation" and "robot_at_location" are "robot at location"."""
    return " ".join(part for part in _EDGE.split(name) if part).lower()


def snake_case(name: str) -> str:
    """Returns a name as Python calls modules: "RobotAtLocation" is "robot_at_location"."""
    return words_of(name).replace(" ", "_")


def joined(name: str) -> str:
    """Returns a name as Python calls classes: "read_code" is "ReadCode"."""
    return "".join(part[:1].upper() + part[1:] for part in _EDGE.split(name) if part)


def constant_name(name: str) -> str:
    """Returns a name as Python calls constants: "RobotAtLocation" is "ROBOT_AT_LOCATION"."""
    return snake_case(name).upper()


PYTHON_TYPES: Mapping[str, str] = {
    "number": "float",
    "integer": "int",
    "text": "str",
    "boolean": "bool",
}
"""Python type by the type of a parameter that is a value."""

_UNITS = {"seconds": "s", "metres": "m", "radians": "rad", "newtons": "N", "kilograms": "kg", "degrees": "deg"}
_PARAMETER = re.compile(r"(?P<key>[^:=\[]*):(?P<type>[^=\[]+?)(=(?P<default>[^\[]*?))?\s*(\[(?P<unit>[^\]]*)\])?")


def read_parameter(text: str, ontology: Ontology) -> Param:
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
    if type_ in PYTHON_TYPES:
        return _value(key, type_, match["default"], match["unit"], help_)
    if match["default"] is not None or match["unit"] is not None:
        raise UsageError(f"parameter '{text}': an element has neither default nor unit")
    class_ = _class(type_, key, ontology)
    return Param(key, class_, _help(help_, f"The {words_of(key)}", key), kind_of(class_, ontology))


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
        known = [*ontology.classes, *PYTHON_TYPES]
        raise UnknownName("class or type", type_, known, where=f"of parameter '{key}'") from error


def _value(key: str, type_: str, default: str | None, unit: str | None, help_: str) -> Param:
    if unit is not None and type_ not in ("number", "integer"):
        raise UsageError(f"parameter '{key}': a {type_} has no unit")
    own = unit or (_UNITS.get(key, "1") if type_ in ("number", "integer") else "")
    said = _help(help_, f"{'How many' if own not in ('', '1') else 'The'} {words_of(key)}", key)
    if default is None:
        return Param(key, type_, said, Kind.ONLINE, None, own)
    return Param(key, type_, said, Kind.OFFLINE, _read(f"parameter '{key}'", type_, default.strip()), own)


def _read(what: str, type_: str, text: str) -> Any:
    known = VALUE_TYPES[type_]
    try:
        value = known.check(known.parse(text.lower() if type_ == "boolean" else text))
    except ValueError:
        raise UsageError(f"{what}: '{text}' is no {type_}") from None
    return float(value) if type_ == "number" else value


def _help(text: str, default: str, key: str) -> str:
    return sentence(text or default, f"help of parameter '{key}'")


def read_constant(text: str, range_: str, what: str) -> Any:
    """Parses a value of the data type of a property.

    Raises:
        UsageError: It is not such a value, or values of that type cannot be compared.
    """
    if range_ not in _COMPARED:
        raise UsageError(f"{what}: values of type {range_} are not compared; leave it out to ask whether there is one")
    try:
        return parse_value(text.lower() if range_ == "xsd:boolean" else text, range_, range_)
    except ValueError as error:
        raise UsageError(f"{what}: {error}") from None


_COMPARED = ("xsd:boolean", "xsd:integer", "xsd:string", "xsd:decimal", "xsd:double", "xsd:float", CLASS_NAME)
