from __future__ import annotations

import enum
import json
import math
import subprocess
import sys
from dataclasses import dataclass
from functools import cache
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.errors import DescriptionError, UnknownName, UsageError
from skiros_py.geometry import Pose
from skiros_py.skills.parameters import Kind, Param, read_arguments
from skiros_py.skills.parameters.values import as_json, as_text, read_value, schema
from skiros_py.testing import tiny_world
from skiros_py.world.world import World


class Side(enum.Enum):
    LEFT = "left"
    RIGHT = "right"


@dataclass(frozen=True)
class Grip:
    width: float
    side: Side = Side.LEFT


@cache
def world() -> World:
    return tiny_world("scene:box_c a tiny:Box ; rdfs:label 'box B' ; sk:on scene:floor .")


def of(type_: Any, **more: Any) -> Param:
    return Param("Key", type_, "What.", **more)


READ = [
    ("number", "0.5", 0.5),
    ("number", "-3", -3),
    ("number", 2, 2),
    ("integer", "12", 12),
    ("text", "1 2", "1 2"),
    ("text", '{"a"', '{"a"'),
    ("boolean", "true", True),
    ("boolean", False, False),
    ("pose", "1 2 3 0 0 0", Pose.of(1, 2, 3)),
    ("pose", [1, 2, 3, 0, 0, 0], Pose.of(1, 2, 3)),
    ("pose", "[1, 2, 3, 0, 0, 0]", Pose.of(1, 2, 3)),
    ("pose", Pose.of(1, 2, 3), Pose.of(1, 2, 3)),
    ("vector", "1 2 3", (1.0, 2.0, 3.0)),
    ("vector", [1, 2], (1.0, 2.0)),
    ("class", "tiny:Ball", "tiny:Ball"),
    ("class", "Ball", "tiny:Ball"),
    (Side, "left", Side.LEFT),
    (Side, Side.RIGHT, Side.RIGHT),
    (Grip, '{"width": 0.5, "side": "right"}', Grip(0.5, Side.RIGHT)),
    (Grip, {"width": 0.5}, Grip(0.5)),
    (Grip, Grip(0.5), Grip(0.5)),
    ("tiny:Box", "box_a", "box_a"),
    ("tiny:Box", "box A", "box_a"),
]


@pytest.mark.parametrize(("type_", "value", "read"), READ)
def test_values_are_read_from_python_json_and_command_lines(type_: Any, value: Any, read: Any) -> None:
    result = read_value(of(type_), value, world())

    assert (result, type(result)) == (read, type(read))


REFUSED = [
    ("number", "fast", "parameter Key takes a finite number, not 'fast'"),
    ("number", "nan", "takes a finite number, not 'nan'"),
    ("number", math.inf, "takes a finite number, not inf"),
    ("number", True, "takes a finite number, not True"),
    ("number", 10**400, "takes a finite number"),
    ("number", [1], r"takes a finite number, not \[1\]"),
    ("number", "[1]", "takes a finite number"),
    ("integer", "1.5", "takes a whole number, not '1.5'"),
    ("integer", 1.0, "takes a whole number, not 1.0"),
    ("text", 5, "takes a text, not 5"),
    ("text", "\ud800", "one half of a character"),
    ("boolean", "yes", "takes true or false, not 'yes'"),
    ("pose", "1 2 3", "takes a pose"),
    ("pose", [1, 2, 3, 0, 0, math.nan], "takes a pose"),
    ("pose", "[[[[", "takes a pose"),
    ("pose", {"x": 1}, "takes a pose"),
    ("vector", "1 two", "takes finite numbers separated by blanks, not '1 two'"),
    ("class", "tiny:Bll", r"unknown class 'tiny:Bll'.*mean 'tiny:Ball'"),
    ("class", 5, "takes the name of a class, not 5"),
    (Side, "up", "takes a Side, not 'up': Input should be 'left' or 'right'"),
    (Grip, '{"width": "wide"}', "takes a Grip, .*: width: Input should be a valid number"),
    (Grip, '{"width": 1', "takes a Grip, .*: Invalid JSON"),
    (Grip, {"width": math.nan}, "every number in it must be finite"),
    (Grip, {}, "width: Field required"),
    ("tiny:Box", "ball_1", r"takes a tiny:Box, and ball_1 is a tiny:Ball\. There are box_a, box_b, box_c\."),
    ("tiny:Box", "box_aa", "unknown element 'box_aa' for parameter Key, a tiny:Box.*mean 'box_a'"),
    ("tiny:Box", "box B", "box_b, box_c are all called 'box B': say which"),
    ("tiny:Giant", "box_a", r"takes a tiny:Giant, and box_a is a tiny:Box\. There is none\."),
    ("tiny:Box", 5, "takes the id of a tiny:Box, not 5"),
]


@pytest.mark.parametrize(("type_", "value", "says"), REFUSED)
def test_bad_values_are_refused_with_key_value_and_what_is_right(type_: Any, value: Any, says: str) -> None:
    with pytest.raises(UsageError, match=says):
        read_value(of(type_), value, world())


@pytest.mark.parametrize("value", [[0.1, -0.3], "0.3"])
def test_each_number_is_within_the_limits(value: Any) -> None:
    assert read_value(of("number", length=0, limits=(-0.2, 0.2)), [0.2, -0.2], world()) == (0.2, -0.2)
    with pytest.raises(UsageError, match=r"it must be between -0\.2 and 0\.2"):
        read_value(of("number", length=0, limits=(-0.2, 0.2)), value, world())


@pytest.mark.parametrize("value", ["1 2 3", "[1, 2, 3]", [1, 2, 3], (1, 2, 3)])
@pytest.mark.parametrize("length", [0, 3])
def test_several_values_are_read_as_a_tuple(value: Any, length: int) -> None:
    assert read_value(of("integer", length=length), value, world()) == (1, 2, 3)


@pytest.mark.parametrize(
    ("value", "says"),
    [
        ("1 2", r"takes 3 values, each a finite number \[m\], not '1 2': it has 2"),
        ("1 2 x", "takes 3 values, each a finite number"),
        (5, "takes 3 values, each a finite number .*, not 5"),
        ([1, 2, True], "takes 3 values"),
        ("[" * 100_000, "takes 3 values"),
    ],
)
def test_a_wrong_number_of_values_is_refused(value: Any, says: str) -> None:
    with pytest.raises(UsageError, match=says):
        read_value(of("number", length=3, unit="m"), value, world())


def test_all_names_of_a_class_list_are_resolved() -> None:
    param = of("class", length=0)

    assert read_value(param, "Ball tiny:Box", world()) == ("tiny:Ball", "tiny:Box")
    with pytest.raises(UnknownName):
        read_value(param, ["Ball", "Bx"], world())


FINITE = st.floats(allow_nan=False, allow_infinity=False)
TEXT = st.text(st.characters(exclude_categories=["Cs"]))
ANGLE = st.floats(-3.0, 3.0)
FAR = st.floats(-100.0, 100.0)
ROUND = {
    "number": FINITE | st.integers(-(2**63), 2**63 - 1),
    "integer": st.integers(-(2**63), 2**63 - 1),
    "text": TEXT,
    "boolean": st.booleans(),
    "vector": st.lists(FINITE, max_size=5).map(tuple),
    Side: st.sampled_from(Side),
    Grip: st.builds(Grip, width=FINITE, side=st.sampled_from(Side)),
}


@pytest.mark.parametrize("type_", list(ROUND), ids=str)
@given(data=st.data())
def test_values_survive_a_round_trip_through_text_and_json(type_: Any, data: st.DataObject) -> None:
    one = data.draw(ROUND[type_])
    cases = [(of(type_), one)]
    if type_ != "vector":
        cases.append((of(type_, length=0), tuple(data.draw(st.lists(ROUND[type_], max_size=3)))))
    for param, value in cases:
        assert read_value(param, as_text(param, value), world()) == value
        assert read_value(param, json.loads(json.dumps(as_json(param, value))), world()) == value


@given(st.tuples(FAR, FAR, FAR), ANGLE, ANGLE, ANGLE)
def test_a_written_pose_is_read_back_to_a_nanometre(
    position: tuple[float, float, float], roll: float, pitch: float, yaw: float
) -> None:
    pose = Pose.of(*position, roll=roll, pitch=pitch, yaw=yaw)
    for written in (as_text(of("pose"), pose), as_json(of("pose"), pose)):
        read = read_value(of("pose"), written, world())
        assert read.distance(pose) < 1e-8
        assert abs(abs(sum(a * b for a, b in zip(read.orientation, pose.orientation, strict=True))) - 1.0) < 1e-8


def test_unspecified_values_are_written_as_empty_text_or_null() -> None:
    assert (as_text(of("number"), None), as_json(of("pose"), None)) == ("", None)


class Opaque:
    pass


def test_a_class_that_cannot_be_written_is_the_authors_fault() -> None:
    with pytest.raises(DescriptionError, match="parameter type Opaque: it cannot be written as JSON"):
        read_value(of(Opaque), Opaque(), world())


def test_describing_a_parameter_of_an_own_class_does_not_load_pydantic() -> None:
    code = (
        "import enum, sys; from skiros_py.skills.parameters import Kind, Param, check_params\n"
        "Side = enum.Enum('Side', 'LEFT RIGHT')\n"
        "check_params((Param('Side', Side, 'Which.', Kind.OFFLINE, Side.LEFT),), 'here')\n"
        "assert 'pydantic' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


PARAMS = (
    Param("Box", "tiny:Box", "Where."),
    Param("Speed", "number", "How fast.", Kind.OFFLINE, 0.5, "m/s"),
    Param("Note", "text", "For people.", Kind.OPTIONAL),
    Param("Rate", "number", "How often.", Kind.CONFIG, 10.0, "Hz"),
)


def test_arguments_are_the_given_values_and_the_defaults() -> None:
    assert read_arguments(PARAMS, {"Box": "box A", "Speed": "2", "Note": None}, world()) == {
        "Box": "box_a",
        "Speed": 2,
        "Note": None,
        "Rate": 10.0,
    }


def test_an_unknown_parameter_is_answered_with_the_nearest() -> None:
    with pytest.raises(UnknownName, match=r"unknown parameter 'speed'.*mean 'Speed'"):
        read_arguments(PARAMS, {"speed": 1.0}, world())


def test_a_parameter_fixed_at_loading_cannot_be_given() -> None:
    with pytest.raises(UsageError, match="parameter Rate is fixed when the module is loaded"):
        read_arguments(PARAMS, {"Rate": 5.0}, world())


def test_all_faults_are_reported_at_once() -> None:
    with pytest.raises(
        UsageError, match=r"unknown parameter 'Bx'.*; parameter Speed takes .*; parameter Rate is fixed"
    ):
        read_arguments(PARAMS, {"Bx": "box_a", "Speed": "x", "Rate": 1}, world())


def test_schemas_contain_what_a_form_shows() -> None:
    assert schema(PARAMS[1]) == {
        "title": "Speed",
        "description": "How fast.",
        "kind": "offline",
        "type": "number",
        "unit": "m/s",
        "default": 0.5,
    }
    assert schema(PARAMS[0])["class"] == "tiny:Box"
    assert schema(of("number", length=3))["maxItems"] == 3
    limited = schema(of("number", length=0, limits=(-0.2, 0.2)))["items"]
    assert (limited["minimum"], limited["maximum"]) == (-0.2, 0.2)
    assert schema(of(Side))["enum"] == ["left", "right"]
    assert schema(of(Grip))["title"] == "Key"
    assert json.dumps(schema(of(Grip, kind=Kind.OFFLINE, default=Grip(0.5))))
