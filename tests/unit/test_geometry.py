from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from skiros_py.geometry import Pose, Primitive, Solid, rotation_matrix, wrap_angle

small = st.floats(-10.0, 10.0)
angles = st.floats(-3.0, 3.0)
poses = st.builds(
    lambda x, y, z, roll, pitch, yaw: Pose.of(x, y, z, roll=roll, pitch=pitch, yaw=yaw),
    small, small, small, angles, st.floats(-1.5, 1.5), angles,
)  # fmt: skip


def close(one: Pose, other: Pose) -> bool:
    return bool(np.allclose(one.matrix(), other.matrix(), atol=1e-9))


@settings(deadline=None)
@given(poses)
def test_a_pose_times_its_inverse_is_nothing(pose: Pose) -> None:
    assert close(pose @ pose.inverse(), Pose())
    assert close(pose.inverse() @ pose, Pose())


@settings(deadline=None)
@given(poses, poses, poses)
def test_poses_compose_like_their_matrices_in_any_grouping(a: Pose, b: Pose, c: Pose) -> None:
    assert close((a @ b) @ c, a @ (b @ c))
    assert np.allclose((a @ b).matrix(), a.matrix() @ b.matrix(), atol=1e-9)


@settings(deadline=None)
@given(poses)
def test_a_pose_survives_the_way_through_its_matrix(pose: Pose) -> None:
    assert close(Pose.from_matrix(pose.matrix()), pose)


@settings(deadline=None)
@given(st.floats(0.0, 10.0) | st.floats(0.0, 2e-4), st.floats(-3.0, 3.0), st.floats(-1.5, 1.5))
def test_a_turn_is_that_of_scipy(angle: float, yaw: float, pitch: float) -> None:
    axis = (math.cos(yaw) * math.cos(pitch), math.sin(yaw) * math.cos(pitch), math.sin(pitch))
    vector = [angle * part for part in axis]

    assert np.allclose(Pose.turn(*vector).orientation, Rotation.from_rotvec(vector).as_quat(), rtol=1e-14, atol=1e-15)


@settings(deadline=None)
@given(poses, small, small, small)
def test_applying_a_pose_to_a_point_is_composing_with_it(pose: Pose, x: float, y: float, z: float) -> None:
    assert np.allclose(pose.apply(np.array([x, y, z])), (pose @ Pose((x, y, z))).position, atol=1e-9)


@settings(deadline=None)
@given(poses, poses)
def test_poses_turn_as_scipy_does_to_the_last_bit(a: Pose, b: Pose) -> None:
    one, other = Rotation.from_quat(a.orientation), Rotation.from_quat(b.orientation)

    assert (a @ b).orientation == tuple((one * other).as_quat())
    assert a.inverse().orientation == tuple(one.inv().as_quat())
    assert np.array_equal(rotation_matrix(a.orientation), one.as_matrix())


def test_a_quaternion_of_length_zero_is_refused() -> None:
    with pytest.raises(ValueError, match="length zero"):
        Pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)).matrix()


@given(st.floats(-1e3, 1e3))
def test_a_wrapped_angle_is_the_same_direction_within_half_a_turn(angle: float) -> None:
    wrapped = wrap_angle(angle)

    assert -math.pi - 1e-9 <= wrapped <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)


@given(angles)
def test_the_yaw_of_a_level_pose_is_what_it_was_made_with(yaw: float) -> None:
    assert Pose.of(1.0, 2.0, 3.0, yaw=yaw).yaw == pytest.approx(yaw)


def test_distance_is_between_origins() -> None:
    assert Pose.of(0, 0, 0, yaw=1.0).distance(Pose.of(3, 4, 0)) == pytest.approx(5.0)


def test_a_box_stands_on_its_origin() -> None:
    low, high = Solid.box(0.2, 0.4, 0.6).bounds()

    assert low == pytest.approx([-0.1, -0.2, 0.0])
    assert high == pytest.approx([0.1, 0.2, 0.6])


def test_a_lying_cylinder_is_as_long_as_its_axis_and_as_wide_as_its_diameter() -> None:
    solid = Solid.from_json(
        '[{"kind": "cylinder", "size": [0.1, 1.0], "at": [0, 0, 0.1], "rpy": [0, 1.5707963267948966, 0]}]'
    )

    low, high = solid.bounds()

    assert (high - low) == pytest.approx([1.0, 0.2, 0.2])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "Expecting property name"),
        ("5", "not a list of primitives"),
        ('[{"size": [1, 1, 1]}]', "'kind'"),
        ('[{"kind": "ball", "size": [1]}]', "a 'box' or a 'cylinder', not 'ball'"),
        ('[{"kind": "box", "size": [1, 1]}]', "a box needs 3 positive lengths"),
        ('[{"kind": "cylinder", "size": [1, -1]}]', "a cylinder needs 2 positive lengths"),
        ("[]", "a solid needs at least one primitive"),
        ("{}", "a solid needs at least one primitive"),
        ('"box"', "not a list of primitives"),
        ("[5]", "not a list of primitives"),
        ('[{"kind": ["box"], "size": [1, 1, 1]}]', "not a list of primitives"),
        ('[{"kind": "box", "size": 1}]', "not a list of primitives"),
        ('[{"kind": "box", "size": ["a", 1, 1]}]', "could not convert"),
        ('[{"kind": "box", "size": [1, 1, NaN]}]', "a box needs 3 positive lengths"),
        ('[{"kind": "box", "size": [1, 1, 1], "at": [0, 0]}]', "'at' takes three finite numbers"),
        ('[{"kind": "box", "size": [1, 1, 1], "at": [NaN, 0, 0]}]', "'at' takes three finite numbers"),
        ('[{"kind": "box", "size": [1, 1, 1], "at": ["a", 0, 0]}]', "could not convert"),
        ('[{"kind": "box", "size": [1, 1, 1], "at": null}]', "not a list of primitives"),
        ('[{"kind": "box", "size": [1, 1, 1], "rpy": [0, 0, 0, 0]}]', "'rpy' takes three finite numbers"),
        ('[{"kind": "box", "size": [1, 1, 1], "rpy": [0, 0, Infinity]}]', "'rpy' takes three finite numbers"),
    ],
)
def test_a_shape_that_cannot_be_read_says_what_is_wrong(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Solid.from_json(text)


@pytest.mark.parametrize("size", [math.nan, math.inf, 0.0, -1.0])
def test_lengths_are_positive_and_finite(size: float) -> None:
    with pytest.raises(ValueError, match="positive lengths"):
        Primitive("box", (1.0, 1.0, size))


@pytest.mark.parametrize(
    "angle", [math.pi, -math.pi, math.nextafter(math.pi, 4.0), math.nextafter(-math.pi, -4.0), 3.0 * math.pi]
)
def test_half_a_turn_is_always_written_as_plus_pi_and_never_more(angle: float) -> None:
    assert wrap_angle(angle) == pytest.approx(math.pi)
    assert wrap_angle(angle) <= math.pi


def test_the_next_number_after_pi_wraps_to_pi() -> None:
    assert wrap_angle(math.nextafter(math.pi, 4.0)) == math.pi


@given(st.floats(-1e6, 1e6))
def test_wrapping_twice_is_wrapping_once(angle: float) -> None:
    assert wrap_angle(wrap_angle(angle)) == wrap_angle(angle)
