"""Claims about trajectories in time."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.geometry import Array
from skiros_py.motion.timing import PERIOD, JointLimits, time_path

LIMITS = JointLimits(np.array([2.175] * 4 + [2.61] * 3), np.full(7, 5.0))


@st.composite
def paths(draw: st.DrawFn) -> Array:
    rng = np.random.default_rng(draw(st.integers(0, 10_000)))
    size = draw(st.sampled_from([0.001, 0.1, 1.0, 3.0]))
    if draw(st.booleans()):
        return size * rng.uniform(-1, 1, (2, 7))
    s = np.linspace(0, 1, draw(st.integers(4, 60)))[:, None]
    bends = rng.uniform(-0.2, 0.2, 7) * np.sin(4 * s * rng.uniform(0, 3, 7) + rng.uniform(-3, 3, 7))
    return np.asarray(size * (rng.uniform(-1, 1, 7) * s + bends))


@settings(max_examples=60, deadline=None)
@given(paths(), st.sampled_from([0.2, 0.6, 1.0]))
def test_no_joint_exceeds_its_speed_or_acceleration_limit(path: Array, share: float) -> None:
    trajectory = time_path(path, LIMITS.scaled(share))

    speed = np.diff(trajectory.positions, axis=0) / PERIOD
    acceleration = np.diff(np.vstack([np.zeros(7), speed, np.zeros(7)]), axis=0) / PERIOD
    assert np.all(np.abs(speed) <= share * LIMITS.velocity)
    assert np.all(np.abs(trajectory.velocities) <= share * LIMITS.velocity)
    assert np.all(np.abs(acceleration) <= 1.02 * share * LIMITS.acceleration)


@settings(max_examples=40, deadline=None)
@given(paths())
def test_a_timed_path_starts_and_ends_at_rest_at_the_ends_of_the_path(path: Array) -> None:
    trajectory = time_path(path, LIMITS)

    assert np.array_equal(trajectory.positions[0], path[0])
    assert np.array_equal(trajectory.positions[-1], path[-1])
    assert not trajectory.velocities[[0, -1]].any()


@settings(max_examples=40, deadline=None)
@given(paths())
def test_the_velocities_are_the_derivatives_of_the_positions(path: Array) -> None:
    trajectory = time_path(path, LIMITS)

    moved = np.diff(trajectory.positions, axis=0)
    said = (trajectory.velocities[1:] + trajectory.velocities[:-1]) / 2 * PERIOD
    assert np.abs(moved - said).max(initial=0.0) < 2e-5


def test_a_long_straight_move_uses_the_limits() -> None:
    path = np.zeros((2, 7))
    path[1, 0] = 2.5

    seconds = (len(time_path(path, LIMITS).positions) - 1) * PERIOD

    fastest = 2.5 / 2.175 + 2.175 / 5.0  # trapezoid: way over speed plus one ramp
    assert fastest <= seconds < fastest + 0.15


def test_the_rate_of_the_path_parameter_is_bounded() -> None:
    path = np.linspace(np.zeros(7), np.full(7, 0.1), 20)

    trajectory = time_path(path, LIMITS, path_rate=0.5)

    assert (trajectory.velocities <= 0.1 * 0.5 + 1e-9).all()
    assert (len(trajectory.positions) - 1) * PERIOD >= 2.0


def test_a_path_of_equal_points_is_one_sample_at_rest() -> None:
    trajectory = time_path(np.ones((3, 7)), LIMITS)

    assert trajectory.positions.tolist() == [[1.0] * 7]
    assert trajectory.velocities.tolist() == [[0.0] * 7]
