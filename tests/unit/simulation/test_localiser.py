"""The estimated pose: wrong by a plausible amount, steady while standing, smooth while driving."""

import numpy as np
import pytest

from skiros_py.devices.base import BaseState, BaseTwist
from skiros_py.devices.localiser import POSITION_SIGMA, YAW_SIGMA, Localiser
from skiros_py.geometry import Pose
from skiros_py.simulation.truth import Truth


def _tour(localiser, stops, way=1.0, steps=50):
    """Drives on and stands again many times; returns the errors at the stops and all errors on the way."""
    at_stops, everywhere = [], []
    for _ in range(stops):
        everywhere += [localiser.estimate(0.0, 0.0, 0.0, way / steps, standing=False) for _ in range(steps)]
        at_stops.append(localiser.estimate(0.0, 0.0, 0.0, 0.0, standing=True))
    return np.array(at_stops), np.array(everywhere)


def test_errors_at_stops_have_the_declared_spread_and_are_independent():
    errors, _ = _tour(Localiser(np.random.default_rng(3)), 3000)
    scaled = errors / (POSITION_SIGMA, POSITION_SIGMA, YAW_SIGMA)

    assert scaled.std(axis=0) == pytest.approx(np.ones(3), abs=0.05)
    assert scaled.mean(axis=0) == pytest.approx(np.zeros(3), abs=0.08)
    assert abs(np.corrcoef(scaled[:-1, 0], scaled[1:, 0])[0, 1]) < 0.08


def test_the_error_fades_smoothly_and_keeps_its_size_on_the_way():
    _, errors = _tour(Localiser(np.random.default_rng(4)), 1000)
    steps = np.abs(np.diff(errors[:, :2], axis=0))

    assert errors[:, 0].std() == pytest.approx(POSITION_SIGMA, rel=0.08)
    assert steps.max() < POSITION_SIGMA / 2  # a step is 20 mm of way; a jump to a new draw is 1.4 sigma on average


def test_the_error_is_another_one_after_each_drive_and_the_same_while_standing(make_cell, kitting):
    cell = make_cell(kitting.cell_spec(start=Pose((-2.0, 0.0, 0.0))))
    truth = Truth(cell)

    def error():
        estimated, true = cell.read().state("base", BaseState).pose, truth.base_pose("base")
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
