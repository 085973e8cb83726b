"""The data types of XML Schema and OWL, as Python values: whole numbers, numbers, truth values, and texts of a form."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from types import MappingProxyType

from skiros_py.world.element import Value

LONGEST_TEXT = 64 * 1024
"""Characters that one literal may have: what is longer belongs into a file of its own."""


@dataclass(frozen=True, slots=True)
class Datatype:
    """One kind of value that a property may have.

    Attributes:
        says: What a value looks like, for messages.
        accepts: CURIEs of the literal types that it is read from.
        check: Returns the value in its own form, or raises ValueError where it is none.
        parse: Reads the text of a literal.
        format: Writes it; numbers are the same after reading again, poses to 1e-9.
    """

    says: str
    accepts: frozenset[str]
    check: Callable[[object], Value]
    parse: Callable[[str], Value]
    format: Callable[[Value], str]


def check_length(text: str) -> str:
    """Returns the text.

    Raises:
        ValueError: It is longer than a literal may be.
    """
    if len(text) > LONGEST_TEXT:
        raise ValueError(f"a text may have {LONGEST_TEXT} characters, and this has {len(text)}")
    return text


# ---------------------------------------------------------------- the data types


def check_string(value: object) -> str:
    """Returns a text that is short enough for a literal as a plain ``str``, or raises ValueError."""
    if not isinstance(value, str):
        raise ValueError
    text = check_length(str.__str__(value))  # of a subclass only the text is kept
    if not text.isascii():
        _check_characters(text)
    return text


def _check_characters(text: str) -> None:
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise ValueError(f"character {error.start + 1} is one half of a character") from None


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


def _format_boolean(value: Value) -> str:
    return "true" if value else "false"


def _format_number(value: Value) -> str:
    assert isinstance(value, float)
    return format(Decimal(repr(float(value))), "f")


def _whole_number_between(least: int, most: int) -> Callable[[object], int]:
    def check(value: object) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            raise ValueError
        return int(value)

    return check


def _text_like(form: str) -> Callable[[object], str]:
    pattern = re.compile(form)

    def check(value: object) -> str:
        text = check_string(value)
        if not pattern.fullmatch(text):
            raise ValueError
        return text

    return check


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
_NUMBER = Datatype("a finite number", _NUMBERS, check_number, _parse_number, _format_number)
_STRING = Datatype("a text", _TEXTS, check_string, str, str)


def _whole_number(name: str) -> Datatype:
    least, most = _LIMITS[name]
    says = "a whole number" if name == "xsd:integer" else f"a whole number from {least} to {most}"
    return Datatype(says, _WHOLE, _whole_number_between(least, most), _parse_whole_number, str)


def _formed_text(name: str) -> Datatype:
    says, form = _FORMS[name]
    # Texts are often left untyped by hand, or typed more precisely than the property asks.
    return Datatype(says, frozenset(_FORMS) | {"xsd:string"}, _text_like(form), str, str)


XSD_DATATYPES: Mapping[str, Datatype] = MappingProxyType(
    {
        **dict.fromkeys(sorted(_TEXTS), _STRING),
        "xsd:boolean": Datatype(
            "true or false", frozenset({"xsd:boolean"}), _check_boolean, _parse_boolean, _format_boolean
        ),
        **{name: _whole_number(name) for name in _LIMITS},
        **dict.fromkeys(sorted(_NUMBERS - _WHOLE), _NUMBER),
        **{name: _formed_text(name) for name in _FORMS},
    }
)
"""By CURIE."""
