"""Property values: Python <-> typed literal, and the check that a value fits its property."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from types import MappingProxyType

from skiros_py.geometry import Pose
from skiros_py.world.element import Value

__all__ = ["DATATYPES", "Datatype", "format_value", "parse_value"]


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


def parse_value(text: str, literal_type: str, range_: str) -> Value:
    """Reads a literal of type ``literal_type`` for a property of range ``range_`` (CURIEs).

    Raises:
        ValueError: It does not fit; the message says what would.
    """
    datatype = DATATYPES[range_]
    if literal_type not in datatype.accepts:
        raise ValueError(f"needs {datatype.says} typed {range_}, got '{text}' typed {literal_type}")
    try:
        return datatype.check(datatype.parse(text))
    except ValueError as error:
        raise ValueError(
            f"needs {datatype.says}, got '{text}'" + (f": {error}" if range_ == "rdf:JSON" else "")
        ) from None


def format_value(value: Value, range_: str) -> str:
    """Returns the text of the literal for a value that was checked before."""
    return DATATYPES[range_].format(value)


def _check_string(value: object) -> str:
    if not isinstance(value, str):
        raise ValueError
    return value


def _check_json(value: object) -> str:
    json.loads(_check_string(value))
    return _check_string(value)


def _check_boolean(value: object) -> bool:
    if not isinstance(value, bool):
        raise ValueError
    return value


def _check_integer(value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError
    return value


def _check_number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError
    return float(value)


def _check_vector(value: object) -> tuple[float, ...]:
    if not isinstance(value, tuple | list):
        raise ValueError
    return tuple(_check_number(number) for number in value)


def _check_pose(value: object) -> Pose:
    if not isinstance(value, Pose):
        raise ValueError
    _check_vector(value.position)
    norm = math.hypot(*_check_vector(value.orientation))
    if abs(norm - 1.0) > 1e-6:
        raise ValueError
    return value


def _parse_boolean(text: str) -> bool:
    if text not in ("true", "1", "false", "0"):
        raise ValueError
    return text in ("true", "1")


def _parse_vector(text: str) -> tuple[float, ...]:
    return tuple(float(word) for word in text.split())


def _parse_pose(text: str) -> Pose:
    x, y, z, roll, pitch, yaw = _check_vector(_parse_vector(text))
    return Pose.of(x, y, z, roll=roll, pitch=pitch, yaw=yaw)


def _format_boolean(value: Value) -> str:
    return "true" if value else "false"


def _format_number(value: Value) -> str:
    assert isinstance(value, float)
    return format(Decimal(repr(float(value))), "f")


def _format_vector(value: Value) -> str:
    assert isinstance(value, tuple)
    return " ".join(repr(float(number)).removesuffix(".0") for number in value)


def _format_pose(value: Value) -> str:
    assert isinstance(value, Pose)
    # Half a turn must not be rounded up to more than that, or reading would turn its sign.
    angles = (math.copysign(min(abs(angle), _HALF_TURN), angle) for angle in _roll_pitch_yaw(value))
    # Adding 0.0 turns -0.0 into 0.0.
    return _format_vector(tuple(round(number, 9) + 0.0 for number in (*value.position, *angles)))


def _roll_pitch_yaw(pose: Pose) -> tuple[float, float, float]:
    x, y, z, w = pose.orientation
    sine = max(-1.0, min(1.0, 2.0 * (w * y - z * x)))
    if abs(sine) > 1.0 - 1e-9:  # straight up or down: only the sum of roll and yaw is determined
        return 0.0, math.copysign(math.pi / 2.0, sine), -math.copysign(2.0, sine) * math.atan2(x, w)
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    return roll, math.asin(sine), pose.yaw


_HALF_TURN = 3.141592653
_NUMBERS = frozenset({"xsd:decimal", "xsd:integer", "xsd:double", "xsd:float"})
_NUMBER = Datatype("a finite number", _NUMBERS, _check_number, float, _format_number)

DATATYPES: Mapping[str, Datatype] = MappingProxyType(
    {
        "xsd:string": Datatype("a text", frozenset({"xsd:string", "rdf:langString"}), _check_string, str, str),
        "xsd:boolean": Datatype(
            "true or false", frozenset({"xsd:boolean"}), _check_boolean, _parse_boolean, _format_boolean
        ),
        "xsd:integer": Datatype("a whole number", frozenset({"xsd:integer"}), _check_integer, int, str),
        "xsd:decimal": _NUMBER,
        "xsd:double": _NUMBER,
        "sk:poseLiteral": Datatype(
            'a pose "x y z roll pitch yaw" of finite numbers [m, rad]',
            frozenset({"sk:poseLiteral"}),
            _check_pose,
            _parse_pose,
            _format_pose,
        ),
        "sk:vectorLiteral": Datatype(
            "finite numbers separated by blanks",
            frozenset({"sk:vectorLiteral"}),
            _check_vector,
            _parse_vector,
            _format_vector,
        ),
        "rdf:JSON": Datatype("a JSON text", frozenset({"rdf:JSON"}), _check_json, str, str),
    }
)
"""What may be the range of a property, by CURIE."""
