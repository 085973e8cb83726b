"""Property values: Python <-> typed literal, and the check that a value fits its property."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from types import MappingProxyType

from skiros_py.geometry import Pose, wrap_angle
from skiros_py.world.element import Value
from skiros_py.world.xsd import XSD_DATATYPES, Datatype, check_length, check_number, check_string

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


def format_value(value: Value, range_: str) -> str:
    """Returns the text of the literal for a value that was checked before."""
    return DATATYPES[literal_type(value, range_)].format(value)


def literal_type(value: Value, range_: str) -> str:
    """Returns the CURIE of the type of the literal for a value of a property of range ``range_``.

    It is the range itself but where that stands for several types.
    """
    if range_ in ("rdf:langString", "rdf:PlainLiteral"):
        return "xsd:string"
    return _type_of(value) if range_ == ANY_LITERAL else range_


def shown(value: object) -> str:
    """Returns a value as shown in messages: in quotes, and truncated if long."""
    text = value if isinstance(value, str) else _written(value)
    cut = text if len(text) <= _LONGEST_SHOWN else f"{text[:_LONGEST_SHOWN]}…"
    return f"'{cut}'" if isinstance(value, str) else cut


def _written(value: object) -> str:
    try:
        return repr(value)
    except ValueError:
        return "a number of thousands of digits"


def _type_of(value: object) -> str:
    for type_, curie in _TYPES.items():
        if isinstance(value, type_):
            return curie
    raise ValueError


def _check_any(value: object) -> Value:
    return DATATYPES[_type_of(value)].check(value)


def _format_any(value: Value) -> str:
    return DATATYPES[_type_of(value)].format(value)


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

_TYPES: Mapping[type, str] = {
    str: "xsd:string",
    bool: "xsd:boolean",  # before int, of which it is a subclass
    int: "xsd:integer",
    float: "xsd:double",
    Pose: "sk:poseLiteral",
    tuple: "sk:vectorLiteral",
}

DATATYPES: Mapping[str, Datatype] = MappingProxyType(
    {
        **XSD_DATATYPES,
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
        CLASS_NAME: Datatype("the name of a class", frozenset({CLASS_NAME, "xsd:string"}), check_string, str, str),
        "rdf:JSON": Datatype("a JSON text", frozenset({"rdf:JSON"}), _check_json, str, str),
        ANY_LITERAL: Datatype("a text, a number or true or false", frozenset(), _check_any, str, _format_any),
    }
)
"""The possible ranges of a property, by CURIE."""
