from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.geometry import Pose
from skiros_py.world.literals import DATATYPES, format_value, parse_value

lengths = st.floats(-100.0, 100.0)
angles = st.floats(-math.pi, math.pi)
poses = st.builds(lambda x, y, z, r, p, w: Pose.of(x, y, z, roll=r, pitch=p, yaw=w), *[lengths] * 3, *[angles] * 3)


@given(poses)
def test_a_pose_is_the_same_after_writing_and_reading(pose: Pose) -> None:
    again = parse_value(format_value(pose), "sk:poseLiteral", "sk:poseLiteral")

    assert isinstance(again, Pose)
    assert np.allclose(again.matrix(), pose.matrix(), atol=1e-4)


@given(lengths, lengths, lengths, angles)
def test_the_text_of_a_pose_on_the_floor_does_not_change_when_written_again(
    x: float, y: float, z: float, yaw: float
) -> None:
    text = format_value(Pose.of(x, y, z, yaw=yaw))

    assert format_value(parse_value(text, "sk:poseLiteral", "sk:poseLiteral")) == text


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False)))
def test_a_vector_is_exactly_the_same_after_writing_and_reading(numbers: list[float]) -> None:
    text = format_value(tuple(numbers))

    assert parse_value(text, "sk:vectorLiteral", "sk:vectorLiteral") == tuple(numbers)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_number_is_exactly_the_same_after_writing_and_reading(number: float) -> None:
    assert parse_value(format_value(number), "xsd:decimal", "xsd:decimal") == number


@pytest.mark.parametrize("text", ["0 0 0", "0 0 0 0 0 nan", "0 0 0 0 0 inf", "x y z r p y", "0 0 0 0 0 0 0"])
def test_an_invalid_pose_is_refused_with_the_expected_format(text: str) -> None:
    with pytest.raises(ValueError, match="needs a pose"):
        parse_value(text, "sk:poseLiteral", "sk:poseLiteral")


@pytest.mark.parametrize(
    ("range_", "value"),
    [("xsd:boolean", 1), ("xsd:integer", 1.0), ("xsd:decimal", True), ("xsd:decimal", math.inf), ("xsd:string", 1)],
)
def test_a_value_of_another_type_is_refused(range_: str, value: object) -> None:
    with pytest.raises(ValueError):  # noqa: PT011  whoever asks words it
        DATATYPES[range_].check(value)
