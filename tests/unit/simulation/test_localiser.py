"""The estimated pose: wrong by a plausible amount, steady while standing, smooth while driving."""

import numpy as np
import pytest

from skiros_py.devices.localiser import HEADING_NOISE, POSITION_NOISE, LocaliserSpec, LocaliserState
from skiros_py.devices.mobile_base import BaseState, BaseTwist
from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose
from skiros_py.ports.simulation import JointReadings
from skiros_py.simulation.truth import Truth


class Treadmill:
    """A robot that stays at the origin, whatever its wheels do; the engine, its joints and links at once."""

    period = 0.005

    def __init__(self):
        self.engine, self.speed, self.place = self, 0.0, Pose()

    def joints(self, _names):
        return self

    link = joints

    def read(self):
        return JointReadings((0.0, 0.0, 0.0), (self.speed, 0.0, 0.0), (0.0, 0.0, 0.0))

    def pose(self):
        return self.place


SPEC = LocaliserSpec("localiser")


def _error(state):
    x, y, _ = state.pose.position
    return x, y, state.pose.yaw


def _tour(seed, stops, spec=SPEC, way=1.0, steps=50):
    """Drives on and stands again many times; returns the errors at the stops and all errors on the way."""
    robot, at_stops, everywhere = Treadmill(), [], []
    localiser = spec.simulate(robot, np.random.default_rng(seed))
    for _ in range(stops):
        robot.speed = way / steps / robot.period
        everywhere += [_error(localiser.state()) for _ in range(steps)]
        robot.speed = 0.0
        at_stops.append([_error(localiser.state()) for _ in range(10)][-1])
    return np.array(at_stops), np.array(everywhere)


def test_errors_at_stops_have_the_declared_spread_and_are_independent():
    errors, _ = _tour(3, 3000)
    scaled = errors / (POSITION_NOISE, POSITION_NOISE, HEADING_NOISE)

    assert scaled.std(axis=0) == pytest.approx(np.ones(3), abs=0.05)
    assert scaled.mean(axis=0) == pytest.approx(np.zeros(3), abs=0.08)
    assert abs(np.corrcoef(scaled[:-1, 0], scaled[1:, 0])[0, 1]) < 0.08


def test_the_localisation_error_changes_smoothly_and_keeps_its_size_while_driving():
    _, errors = _tour(4, 1000)
    steps = np.abs(np.diff(errors[:, :2], axis=0))

    assert errors[:, 0].std() == pytest.approx(POSITION_NOISE, rel=0.08)
    assert steps.max() < POSITION_NOISE / 2  # a step is 20 mm of way; a jump to a new draw is 1.4 sigma on average


def test_the_localisation_error_changes_with_each_drive_and_is_constant_at_standstill(make_cell, kitting):
    cell = make_cell(kitting.cell_spec(start=Pose((-2.0, 0.0, 0.0))))
    truth = Truth(cell)

    def error():
        estimated, true = cell.read().state("localiser", LocaliserState).pose, truth.base_pose("base")
        return np.subtract(estimated.position, true.position)

    before = error()
    for _ in range(100):
        cell.exchange({})
    standing = error()
    for _ in range(500):
        cell.exchange({"base": BaseTwist(0.4, 0.0)})
    for _ in range(200):
        cell.exchange({})

    assert np.abs(before).max() > 1e-4
    assert standing == pytest.approx(before, abs=1e-9)
    assert np.linalg.norm(error() - before) > 1e-4


def test_localisation_errors_are_as_large_as_declared_on_the_individual():
    errors, _ = _tour(5, 500, LocaliserSpec("localiser", 0.02, 0.0))

    assert errors[:, :2].std(axis=0) == pytest.approx((0.02, 0.02), rel=0.1)
    assert np.abs(errors[:, 2]).max() == 0.0


def test_a_simulated_localiser_of_an_unsimulated_robot_is_refused():
    robot = Treadmill()
    robot.place = Pose((1.0, 0.0, 0.0))

    with pytest.raises(DeviceError, match="localiser: what moves its robot is not simulated"):
        LocaliserSpec("localiser").simulate(robot, np.random.default_rng(1))


def test_odometry_follows_the_wheels_and_is_independent_of_the_localiser(make_cell, kitting):
    cell = make_cell(kitting.cell_spec(start=Pose((-2.0, 0.0, 0.0))))
    truth = Truth(cell)
    for twist in [BaseTwist(0.4, 0.3)] * 400 + [BaseTwist(0.0, 0.0)] * 200:
        cell.exchange({"base": twist})
    odometry, estimate = cell.read().state("base", BaseState).pose, cell.read().state("localiser", LocaliserState).pose

    assert odometry.distance(truth.base_pose("base")) < 0.002
    assert odometry.yaw == pytest.approx(truth.base_pose("base").yaw, abs=0.005)
    assert odometry != estimate
