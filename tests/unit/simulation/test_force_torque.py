"""What a force-torque sensor at the wrist measures, on both engines."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from skiros_py.devices.arm import ArmSpec, ArmTarget
from skiros_py.devices.force_torque import ForceTorqueSpec, ForceTorqueState
from skiros_py.geometry import Array, Pose, Solid, rotation_matrix
from skiros_py.ports.cell import BodySpec, CellSpec
from skiros_py.ports.simulation import Wrench
from skiros_py.simulation.cell import SimulatedCell
from skiros_py.testing.conformance import small_cell

SETTLED = 250
POSTURES = (
    (-1.5708, -0.6, 0.0, -2.4, 0.0, 1.9, 0.7854),
    (-1.5708, -0.6, 0.0, -2.4, 0.5, 2.6, 0.2),
    (-1.2, -0.4, 0.3, -2.0, -1.2, 1.0, 1.5),
)
CELL = small_cell(cameras=False)
ROBOT = CELL.groups[0]
SENSOR = ROBOT.of(ForceTorqueSpec)[0]


@pytest.fixture(params=["pybullet", "mujoco"])
def cell(request: pytest.FixtureRequest) -> Iterator[SimulatedCell]:
    """A cell with a sensor that measures exactly."""
    exact = replace(SENSOR, force_noise=0.0, torque_noise=0.0)
    devices = tuple(exact if device is SENSOR else device for device in ROBOT.devices)
    made = SimulatedCell(CellSpec((), (replace(ROBOT, devices=devices),)), seed=1, engine=request.param)
    yield made
    made.close()


def measured(cell: SimulatedCell, posture: tuple[float, ...] = POSTURES[0], push: Wrench | None = None) -> Array:
    """The mean over some cycles in a posture: force and torque in one row; joints that hold tremble a little."""
    rows = []
    for cycle in range(2 * SETTLED):
        if push is not None:
            cell.scene.engine.apply_wrench("robot", push, link=SENSOR.frame)
        state = cell.exchange({"arm": ArmTarget(posture, (0.0,) * 7)}).state(SENSOR.id, ForceTorqueState)
        if cycle >= SETTLED:
            rows.append([*state.force, *state.torque])
    return np.asarray(np.mean(rows, axis=0))


@pytest.mark.parametrize("posture", POSTURES)
def test_the_weight_of_the_empty_hand_is_left_out_in_each_posture(
    cell: SimulatedCell, posture: tuple[float, ...]
) -> None:
    assert measured(cell, posture) == pytest.approx([0.0] * 6, abs=0.2)


def test_what_pushes_the_hand_is_measured_in_the_frame_of_the_sensor(cell: SimulatedCell) -> None:
    push = Wrench((3.0, 4.0, 12.0), (0.0, 0.5, 0.2))
    felt = measured(cell, POSTURES[1], push)
    turn = rotation_matrix(cell.scene.robots[0].model.link(SENSOR.frame).pose().orientation)

    assert felt[:3] == pytest.approx(turn.T @ push.force, abs=0.15)
    assert felt[3:] == pytest.approx(turn.T @ push.torque, abs=0.05)


def test_it_measures_with_noise_which_is_a_function_of_the_seed() -> None:
    def states(seed: int) -> list[ForceTorqueState]:
        cell = SimulatedCell(CELL, seed=seed)
        found = [cell.exchange({}).state(SENSOR.id, ForceTorqueState) for _ in range(SETTLED)]
        cell.close()
        return found

    one, again, other = states(1), states(1), states(2)

    assert one == again != other
    assert 0.5 < np.std([state.force[2] for state in one]) / SENSOR.force_noise < 2.0


@pytest.mark.parametrize("engine", ["pybullet", "mujoco"])
def test_measuring_does_not_change_what_is_measured(engine: str) -> None:
    """A box falls onto the hand of two robots, of which one has no sensor."""
    box = BodySpec("box", "test:Box", Solid.box(0.05, 0.05, 0.05), mass=0.3, pose=Pose((0.60, 0.0, 1.4)))
    ends = []
    for devices in (ROBOT.devices, tuple(device for device in ROBOT.devices if device is not SENSOR)):
        cell = SimulatedCell(CellSpec((box,), (replace(ROBOT, devices=devices),)), seed=1, engine=engine)
        home = ROBOT.of(ArmSpec)[0].home
        for cycle in range(SETTLED):
            turned = (home[0] + 0.001 * cycle, *home[1:])
            cell.exchange({"arm": ArmTarget(turned, (0.0,) * 7)})
        ends.append(cell.state_bytes())
        cell.close()

    assert ends[0] == ends[1]
