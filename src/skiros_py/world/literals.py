"""Property values: Python <-> typed literal, by the data types of XML Schema and OWL; and the check that they fit."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from types import MappingProxyType
from typing import Any

from skiros_py.geometry import Pose, wrap_angle
from skiros_py.messages import Message
from skiros_py.world.element import Value

LONGEST_TEXT = 64 * 1024
"""Maximum length of a literal: longer texts belong into files of their own."""


@dataclass(frozen=True, slots=True)
class Datatype:
    """One kind of value that a property may have.

    Attributes:
        says: Description of its values, for messages.
        accepts: CURIEs of the literal types that it is read from.
        check: Returns a value in normal form, or raises ValueError.
        parse: Reads the text of a literal.
    """

    says: str
    accepts: frozenset[str]
    check: Callable[[object], Value]
    parse: Callable[[str], Value]

    def fits(self, value: object) -> bool:
        """Returns whether a value is valid."""
        try:
            self.check(value)
        except ValueError:
            return False
        return True


def check_length(text: str) -> str:
    """Returns the text.

    Raises:
        ValueError: It is longer than a literal may be.
    """
    if len(text) > LONGEST_TEXT:
        raise ValueError(
            Message("a text may have {most} characters, and this has {count}", most=LONGEST_TEXT, count=len(text))
        )
    return text


# ---------------------------------------------------------------- the data types


def check_string(value: object) -> str:
    """Returns a text that is short enough for a literal as a plain ``str``, or raises ValueError."""
    if not isinstance(value, str):
        raise ValueError
    text = check_length(str.__str__(value))  # of a subclass only the text is kept
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise ValueError(f"character {error.start + 1} is one half of a character") from None
    return text


def check_number(value: object) -> float:
    """Returns a finite number as float, or raises ValueError."""
    if type(value) is float and math.isfinite(value):
        return value
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError
    try:
        number = float(value)
    except OverflowError:
        raise ValueError from None
    if not math.isfinite(number):
        raise ValueError
    return number


def _parse_number(text: str) -> float:
    if not re.fullmatch(r"\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*", text, re.ASCII):
        raise ValueError
    return float(text)


def _parse_whole_number(text: str) -> int:
    if not re.fullmatch(r"\s*[+-]?\d{1,40}\s*", text, re.ASCII):
        raise ValueError
    return int(text)


def _check_boolean(value: object) -> bool:
    if not isinstance(value, bool):
        raise ValueError
    return value


def _parse_boolean(text: str) -> bool:
    if text not in ("true", "1", "false", "0"):
        raise ValueError
    return text in ("true", "1")


_SIGNED = {"xsd:byte": 8, "xsd:short": 16, "xsd:int": 32, "xsd:long": 64}
_UNSIGNED = {"xsd:unsignedByte": 8, "xsd:unsignedShort": 16, "xsd:unsignedInt": 32, "xsd:unsignedLong": 64}
_LEAST, _MOST = -(2**63), 2**63 - 1  # the triple store has 64 bits for a number
_LIMITS: Mapping[str, tuple[int, int]] = {
    "xsd:integer": (_LEAST, _MOST),
    "xsd:nonNegativeInteger": (0, _MOST),
    "xsd:positiveInteger": (1, _MOST),
    "xsd:nonPositiveInteger": (_LEAST, 0),
    "xsd:negativeInteger": (_LEAST, -1),
    **{name: (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) for name, bits in _SIGNED.items()},
    **{name: (0, 2**bits - 1) for name, bits in _UNSIGNED.items()},
}

_MONTH, _DAY = r"(0[1-9]|1[0-2])", r"(0[1-9]|[12]\d|3[01])"
_ZONE = r"(Z|[+-](0\d|1[0-4]):[0-5]\d)"
_DATE = rf"-?\d{{4,9}}-{_MONTH}-{_DAY}"
_TIME = r"([01]\d|2[0-3]):[0-5]\d:[0-5]\d(\.\d+)?"
_DURATION = r"-?P(?=.)(\d+Y)?(\d+M)?(\d+D)?(T(?=.)(\d+H)?(\d+M)?(\d+(\.\d+)?S)?)?"

_FORMS: Mapping[str, tuple[str, str]] = {
    "xsd:dateTime": ('a moment "2025-01-31T14:05:00Z"', rf"{_DATE}T{_TIME}{_ZONE}?"),
    "xsd:dateTimeStamp": ('a moment with its time zone "2025-01-31T14:05:00Z"', rf"{_DATE}T{_TIME}{_ZONE}"),
    "xsd:date": ('a date "2025-01-31"', rf"{_DATE}{_ZONE}?"),
    "xsd:time": ('a time of day "14:05:00"', rf"{_TIME}{_ZONE}?"),
    "xsd:gYear": ('a year "2025"', rf"-?\d{{4,9}}{_ZONE}?"),
    "xsd:gYearMonth": ('a month of a year "2025-01"', rf"-?\d{{4,9}}-{_MONTH}{_ZONE}?"),
    "xsd:duration": ('a duration "P1DT2H30M"', _DURATION),
    "xsd:dayTimeDuration": ('a duration "P1DT2H30M"', _DURATION),
    "xsd:anyURI": ("an IRI", r"[^\s<>\"{}|\\^`]*"),
    "xsd:token": ("a text without line breaks or needless blanks", r"([^\s]+( [^\s]+)*)?"),
    "xsd:normalizedString": ("a text without line breaks or tabs", r"[^\t\n\r]*"),
    "xsd:language": ('a language "en-GB"', r"[a-zA-Z]{1,8}(-[a-zA-Z0-9]{1,8})*"),
    "xsd:Name": ("a name", r"[^\W\d][\w.:-]*"),
    "xsd:NCName": ("a name without colon", r"[^\W\d][\w.-]*"),
    "xsd:NMTOKEN": ("a word", r"[\w.:-]+"),
    "xsd:hexBinary": ("pairs of hexadecimal digits", r"([0-9a-fA-F]{2})*"),
    "xsd:base64Binary": ("base64", r"[A-Za-z0-9+/=\s]*"),
}

_TEXTS = frozenset({"xsd:string", "rdf:langString", "rdf:PlainLiteral", "rdf:XMLLiteral", "rdf:HTML"})
_WHOLE = frozenset(_LIMITS)
_NUMBERS = _WHOLE | {"xsd:decimal", "xsd:double", "xsd:float", "owl:real", "owl:rational"}
_NUMBER = Datatype(Message("a finite number"), _NUMBERS, check_number, _parse_number)
_STRING = Datatype(Message("a text"), _TEXTS, check_string, str)


def _whole_number(name: str) -> Datatype:
    least, most = _LIMITS[name]

    def check(value: object) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            raise ValueError
        return int(value)

    says = Message("a whole number")
    if name != "xsd:integer":
        says = Message("a whole number from {least} to {most}", least=least, most=most)
    return Datatype(says, _WHOLE, check, _parse_whole_number)


def _formed_text(name: str) -> Datatype:
    says, form = _FORMS[name]

    def check(value: object) -> str:
        text = check_string(value)
        if not re.fullmatch(form, text):
            raise ValueError
        return text

    # Texts are often left untyped by hand, or typed more precisely than the property asks.
    return Datatype(says, frozenset(_FORMS) | {"xsd:string"}, check, str)


XSD_DATATYPES: Mapping[str, Datatype] = MappingProxyType(
    {
        **dict.fromkeys(sorted(_TEXTS), _STRING),
        "xsd:boolean": Datatype(Message("true or false"), frozenset({"xsd:boolean"}), _check_boolean, _parse_boolean),
        **{name: _whole_number(name) for name in _LIMITS},
        **dict.fromkeys(sorted(_NUMBERS - _WHOLE), _NUMBER),
        **{name: _formed_text(name) for name in _FORMS},
    }
)
"""By CURIE."""


ANY_LITERAL = "rdfs:Literal"
"""Range of a property whose values may be of any type."""

CLASS_NAME = "sk:className"
"""Range of a property whose values name classes of the ontology."""


def parse_value(text: str, literal_type: str, range_: str) -> Value:
    """Reads a literal of type ``literal_type`` for a property of range ``range_`` (CURIEs).

    Raises:
        ValueError: It does not fit; the message says what would.
    """
    datatype = DATATYPES[range_]
    if range_ == ANY_LITERAL:
        return any_value(check_length(text), literal_type)
    if literal_type not in datatype.accepts:
        raise ValueError(f"needs {datatype.says} typed {range_}, got {shown(text)} typed {literal_type}")
    try:
        return datatype.check(datatype.parse(check_length(text)))
    except ValueError as error:
        hint = f": {error}" if datatype.parse is str and str(error) else ""
        raise ValueError(f"needs {datatype.says}, got {shown(text)}{hint}") from None


def any_value(text: str, literal_type: str) -> Value:
    """Reads an unchecked literal: the text itself if it is not a valid value of its type."""
    if literal_type not in DATATYPES or literal_type == ANY_LITERAL:
        return text
    try:
        return parse_value(text, literal_type, literal_type)
    except ValueError:
        return text


def format_value(value: Value) -> str:
    """Returns the text of the literal for a value that was checked before.

    Reading it gives equal numbers, and poses equal to 1e-9.
    """
    return _type_of(value)[1](value)


def literal_type(value: Value, range_: str) -> str:
    """Returns the CURIE of the type of the literal for a value of a property of range ``range_``.

    It is the range itself but where that stands for several types.
    """
    if range_ in ("rdf:langString", "rdf:PlainLiteral"):
        return "xsd:string"
    return _type_of(value)[0] if range_ == ANY_LITERAL else range_


def shown(value: object) -> str:
    """Returns a value as shown in messages: in quotes, and truncated if long."""
    try:
        text = value if isinstance(value, str) else repr(value)
    except ValueError:
        text = "a number of thousands of digits"
    cut = text if len(text) <= _LONGEST_SHOWN else f"{text[:_LONGEST_SHOWN]}…"
    return f"'{cut}'" if isinstance(value, str) else cut


def _type_of(value: object) -> tuple[str, Callable[[Any], str]]:
    """The type of the literal for a value, and the function that returns its text."""
    for type_, literal in _TYPES.items():
        if isinstance(value, type_):
            return literal
    raise ValueError


def _check_any(value: object) -> Value:
    return DATATYPES[_type_of(value)[0]].check(value)


def _check_json(value: object) -> str:
    text = check_string(value)
    try:
        json.loads(text)
    except RecursionError:
        raise ValueError("it is nested too deep") from None
    return text


def _check_vector(value: object) -> tuple[float, ...]:
    if not isinstance(value, tuple | list):
        raise ValueError
    if len(value) > _LONGEST_VECTOR:
        raise ValueError(f"a vector may have {_LONGEST_VECTOR} numbers, and this has {len(value)}")
    return tuple(check_number(number) for number in value)


def _check_pose(value: object) -> Pose:
    if not isinstance(value, Pose):
        raise ValueError
    x, y, z = _check_vector(value.position)
    quaternion = a, b, c, d = _check_vector(value.orientation)
    if abs(math.hypot(*quaternion) - 1.0) > 1e-6:
        raise ValueError
    return Pose((x, y, z), (a, b, c, d))


def _parse_vector(text: str) -> tuple[float, ...]:
    if "_" in text or not text.isascii():  # Python's float would read "1_0" and digits of other scripts
        raise ValueError
    return tuple(float(word) for word in text.split())


def _parse_pose(text: str) -> Pose:
    x, y, z, roll, pitch, yaw = _check_vector(_parse_vector(text))
    return Pose.of(x, y, z, roll=roll, pitch=pitch, yaw=yaw)


def _format_vector(value: Iterable[float]) -> str:
    return " ".join(repr(float(number)).removesuffix(".0") for number in value)


def _format_pose(value: Pose) -> str:
    # Half a turn must not be rounded up to more than that, or reading would turn its sign.
    angles = (math.copysign(min(abs(angle), _HALF_TURN), angle) for angle in _roll_pitch_yaw(value))
    # Adding 0.0 turns -0.0 into 0.0.
    return _format_vector(round(number, 9) + 0.0 for number in (*value.position, *angles))


def _roll_pitch_yaw(pose: Pose) -> tuple[float, float, float]:
    """Exact also close to straight up or down (Bernardes and Viollet, 2022)."""
    x, y, z, w = pose.orientation
    up, down = math.hypot(w + y, x - z), math.hypot(w - y, x + z)
    half_difference = math.atan2(x - z, w + y) if up > _STRAIGHT else 0.0
    half_sum = math.atan2(x + z, w - y) if down > _STRAIGHT else 0.0
    if min(up, down) <= _STRAIGHT:  # only the sum or the difference of roll and yaw is determined
        return 0.0, math.copysign(math.pi / 2.0, up - down), wrap_angle(2.0 * (half_sum - half_difference))
    pitch = math.pi / 2.0 - 2.0 * math.atan2(down, up)
    return wrap_angle(half_sum + half_difference), pitch, wrap_angle(half_sum - half_difference)


_STRAIGHT = 2e-10
_HALF_TURN = 3.141592653
_LONGEST_VECTOR = 2048  # as text it is shorter than a literal may be
_LONGEST_SHOWN = 100

_TYPES: Mapping[type, tuple[str, Callable[[Any], str]]] = {
    str: ("xsd:string", str),
    bool: ("xsd:boolean", lambda value: "true" if value else "false"),  # before int, of which it is a subclass
    int: ("xsd:integer", str),
    float: ("xsd:double", lambda value: format(Decimal(repr(float(value))), "f")),
    Pose: ("sk:poseLiteral", _format_pose),
    tuple: ("sk:vectorLiteral", _format_vector),
}

DATATYPES: Mapping[str, Datatype] = MappingProxyType(
    {
        **XSD_DATATYPES,
        "sk:poseLiteral": Datatype(
            Message('a pose "x y z roll pitch yaw" of finite numbers [m, rad]'),
            frozenset({"sk:poseLiteral"}),
            _check_pose,
            _parse_pose,
        ),
        "sk:vectorLiteral": Datatype(
            Message("finite numbers separated by blanks"),
            frozenset({"sk:vectorLiteral"}),
            _check_vector,
            _parse_vector,
        ),
        CLASS_NAME: Datatype(Message("the name of a class"), frozenset({CLASS_NAME, "xsd:string"}), check_string, str),
        "rdf:JSON": Datatype(Message("a JSON text"), frozenset({"rdf:JSON"}), _check_json, str),
        ANY_LITERAL: Datatype(Message("a text, a number or true or false"), frozenset(), _check_any, str),
    }
)
"""The possible ranges of a property, by CURIE."""
