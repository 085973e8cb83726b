"""What every driver of a robot cell must do: simulated, pretended or real."""

# ruff: noqa: D102 - the names of tests say what they claim

from __future__ import annotations

import json
import math
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import ClassVar

import pytest

from skiros_py.devices.arm import ArmSpec, ArmState, ArmTarget
from skiros_py.devices.camera import CameraSpec
from skiros_py.devices.gripper import GripperSpec, GripperState, GripperTarget
from skiros_py.devices.mobile_base import BaseSpec, BaseState, BaseTwist
from skiros_py.errors import DeviceError
from skiros_py.ports.cell import CellSpec, SpecT
from skiros_py.ports.driver import CellDriver
from skiros_py.ports.values import Commands, Snapshot
from skiros_py.testing.conformance.cells import small_cell
from skiros_py.testing.conformance.pending import check_pending

_NOTHING: Commands = {}


class CellDriverContract(ABC):
    """Claims about a :class:`~skiros_py.ports.driver.CellDriver`; every test gets a cell of its own.

    The robot needs 0.5 m of free floor ahead and behind. Devices that a robot does not have are not tested.

    Class attributes:
        inertia: False for an adapter whose devices do at once what they are commanded to, without limits of speed and
            acceleration.
        pictures: False for an adapter whose cameras cannot be asked: it must refuse.
        arm_tolerance: How well an arm keeps its set-points at rest [rad].
        gap_tolerance: How well a gripper keeps a gap [m].
        speed_tolerance: How well a base keeps a speed: share of its greatest speed.
    """

    inertia: ClassVar[bool] = True
    pictures: ClassVar[bool] = True
    arm_tolerance: ClassVar[float] = 0.01
    gap_tolerance: ClassVar[float] = 0.003
    speed_tolerance: ClassVar[float] = 0.1

    @abstractmethod
    def make(self, spec: CellSpec) -> CellDriver:
        """Returns the adapter for a cell, at rest."""

    def spec(self) -> CellSpec:
        """Returns the cell; override it for a robot of another kind."""
        return small_cell(cameras=self.pictures)

    @pytest.fixture
    def cell(self) -> Iterator[CellDriver]:
        """A cell of its own for each test."""
        driver = self.make(self.spec())
        yield driver
        driver.close()

    # ------------------------------------------------------------------ time

    def test_cycles_count_up_and_time_is_cycle_times_period(self, cell: CellDriver) -> None:
        snapshots = [cell.read(), *(cell.exchange(_NOTHING) for _ in range(10))]

        assert cell.period > 0.0
        assert [after.cycle - before.cycle for before, after in pairwise(snapshots)] == [1] * 10
        assert all(s.time == pytest.approx(s.cycle * cell.period, abs=1e-9) for s in snapshots)

    def test_reading_gives_the_last_snapshot_and_takes_no_time(self, cell: CellDriver) -> None:
        last = cell.exchange(_NOTHING)

        assert [cell.read() for _ in range(3)] == [last] * 3

    def test_a_snapshot_stays_as_it_was(self, cell: CellDriver) -> None:
        first = cell.read()
        devices = dict(first.devices)

        for _ in range(20):
            cell.exchange(self._moving(first))

        assert first.devices == devices

    # ------------------------------------------------------------------ devices

    def test_every_device_answers_with_finite_numbers(self, cell: CellDriver) -> None:
        spec = self.spec()
        now = cell.exchange(_NOTHING)

        assert set(now.devices) == {id_ for id_, device in spec.devices.items() if device.state_type is not None}
        assert all(type(state) is spec.devices[id_].state_type for id_, state in now.devices.items())
        assert dict(cell.devices) == spec.devices
        assert all(len(now.state(arm.id, ArmState).positions) == len(arm.joints) for arm in spec.of(ArmSpec))
        assert all(len(now.state(arm.id, ArmState).velocities) == len(arm.joints) for arm in spec.of(ArmSpec))
        for id_, state in now.devices.items():
            json.dumps(spec.devices[id_].encode(state), allow_nan=False)  # raises if a number is not finite

    def test_everything_stands_at_the_start(self, cell: CellDriver) -> None:
        now = _after(cell, 0.2)

        assert _stands(now)

    @pytest.mark.parametrize("kind", ["arms", "grippers", "bases"])
    def test_a_command_for_an_unknown_device_is_refused(self, cell: CellDriver, kind: str) -> None:
        wanted = {"arms": ArmTarget((0.0,), (0.0,)), "grippers": GripperTarget(0.0, 1.0), "bases": BaseTwist(0.0, 0.0)}

        with pytest.raises(DeviceError, match="unknown_device"):
            cell.exchange({"unknown_device": wanted[kind]})

    def test_a_refused_command_takes_no_time_and_it_goes_on(self, cell: CellDriver) -> None:
        before = cell.exchange(_NOTHING).cycle
        with pytest.raises(DeviceError):
            cell.exchange({"unknown_device": BaseTwist(0.0, 0.0)})

        assert cell.exchange(_NOTHING).cycle == before + 1

    # ------------------------------------------------------------------ arms

    def test_an_arm_follows_its_set_points(self, cell: CellDriver) -> None:
        for arm in self._each(ArmSpec):
            start = cell.read().state(arm.id, ArmState).positions
            wanted = _set_point(start, 1.0).positions

            self._swing(cell, arm.id, start, 1.0)
            reached = _after(cell, 0.5).state(arm.id, ArmState).positions

            assert reached == pytest.approx(wanted, abs=self.arm_tolerance)

    def test_an_arm_without_a_command_holds(self, cell: CellDriver) -> None:
        for arm in self._each(ArmSpec):
            self._swing(cell, arm.id, cell.read().state(arm.id, ArmState).positions, 1.0)
            before = _after(cell, 0.5).state(arm.id, ArmState)
            after = _after(cell, 1.0).state(arm.id, ArmState)

            assert after.still
            assert after.positions == pytest.approx(before.positions, abs=self.arm_tolerance)

    def test_an_arm_whose_commands_cease_in_motion_comes_to_a_standstill(self, cell: CellDriver) -> None:
        for arm in self._each(ArmSpec):
            self._swing(cell, arm.id, cell.read().state(arm.id, ArmState).positions, 0.5)
            if self.inertia:
                assert not cell.read().state(arm.id, ArmState).still, "it says that it stands in the middle of a motion"

            assert _after(cell, cell.braking_time + cell.period).state(arm.id, ArmState).still

    # ------------------------------------------------------------------ grippers

    def test_a_gripper_keeps_its_target_until_it_gets_another(self, cell: CellDriver) -> None:
        for gripper in self._each(GripperSpec):
            half = gripper.max_gap / 2.0

            cell.exchange({gripper.id: GripperTarget(half, gripper.max_force / 2.0)})
            soon = _after(cell, 2.0).state(gripper.id, GripperState)
            later = _after(cell, 2.0).state(gripper.id, GripperState)

            assert soon.gap == pytest.approx(half, abs=self.gap_tolerance), "one command is enough"
            assert later.gap == pytest.approx(half, abs=self.gap_tolerance), "nothing is let go by omission"
            assert later.still

    # ------------------------------------------------------------------ bases

    def test_a_base_drives_ahead_and_turns_as_told(self, cell: CellDriver) -> None:
        for base in self._each(BaseSpec):
            start = cell.read().state(base.id, BaseState).pose
            ahead = self._driven(cell, base, BaseTwist(base.max_linear / 4.0, 0.0), 1.0)
            stood = self._driven(cell, base, BaseTwist(0.0, 0.0), cell.braking_time)
            turned = self._driven(cell, base, BaseTwist(0.0, base.max_angular / 4.0), 1.0)

            assert ahead.linear == pytest.approx(base.max_linear / 4.0, abs=self.speed_tolerance * base.max_linear)
            assert (start.inverse() @ ahead.pose).position[0] > 0.0
            assert turned.angular == pytest.approx(base.max_angular / 4.0, abs=self.speed_tolerance * base.max_angular)
            assert (stood.pose.inverse() @ turned.pose).yaw > 0.0

    def test_a_base_drives_sideways_as_told_if_it_can(self, cell: CellDriver) -> None:
        for base in self._each(BaseSpec):
            if not base.drives_sideways:
                pytest.skip("it has a differential drive")
            start = cell.read().state(base.id, BaseState).pose
            aside = self._driven(cell, base, BaseTwist(0.0, 0.0, base.max_sideways / 4.0), 1.0)

            slack = self.speed_tolerance * base.max_sideways
            assert aside.sideways == pytest.approx(base.max_sideways / 4.0, abs=slack)
            assert (start.inverse() @ aside.pose).position[1] > 0.0
            assert aside.linear == pytest.approx(0.0, abs=self.speed_tolerance * base.max_linear)

    def test_a_base_without_a_command_brakes_and_stands(self, cell: CellDriver) -> None:
        for base in self._each(BaseSpec):
            self._driven(cell, base, BaseTwist(base.max_linear / 4.0, 0.0), 0.5)

            stopped = _after(cell, cell.braking_time + cell.period).state(base.id, BaseState)
            later = _after(cell, 1.0).state(base.id, BaseState)

            assert stopped.still
            assert later.still
            assert abs(later.linear) <= 0.01
            assert later.pose.distance(stopped.pose) <= 0.02

    def test_a_base_that_drives_is_not_still(self, cell: CellDriver) -> None:
        for base in self._each(BaseSpec):
            driving = self._driven(cell, base, BaseTwist(base.max_linear / 4.0, 0.0), 0.5)
            stopped = _after(cell, cell.braking_time + cell.period).state(base.id, BaseState)
            turning = self._driven(cell, base, BaseTwist(0.0, base.max_angular / 4.0), 0.5)

            assert not driving.still
            assert stopped.still
            assert not turning.still

    def test_a_base_keeps_its_limits_whatever_it_is_told(self, cell: CellDriver) -> None:
        if not self.inertia:
            pytest.skip("it has no inertia")
        for base in self._each(BaseSpec):
            far = BaseTwist(9.0 * base.max_linear, 0.0)
            count = int(0.5 / cell.period)
            speeds = [cell.read().state(base.id, BaseState).linear]
            speeds += [cell.exchange({base.id: far}).state(base.id, BaseState).linear for _ in range(count)]
            steps = [abs(after - before) for before, after in pairwise(speeds)]

            assert max(speeds) <= base.max_linear * (1.0 + self.speed_tolerance)
            assert max(steps) <= base.max_linear_acceleration * cell.period * 1.5

    # ------------------------------------------------------------------ halting

    def test_halting_returns_at_once_in_any_thread(self, cell: CellDriver) -> None:
        cell.exchange(self._moving(cell.read()))
        began = time.monotonic()

        _in_thread(cell.halt)

        assert time.monotonic() - began < 0.5

    def test_a_halted_cell_brakes_whatever_is_commanded(self, cell: CellDriver) -> None:
        self._run(cell, 0.5)
        _in_thread(cell.halt)
        stopped = self._run(cell, cell.braking_time + cell.period)
        later = self._run(cell, 0.5)

        assert _stands(stopped)
        assert _stands(later)
        assert all(
            base.pose.distance(stopped.state(b, BaseState).pose) <= 0.02 for b, base in later.of(BaseState).items()
        )

    def test_a_released_cell_stands_until_it_is_told_to_move(self, cell: CellDriver) -> None:
        self._run(cell, 0.5)
        cell.halt()
        _after(cell, cell.braking_time + cell.period)

        cell.release()
        waiting = _after(cell, 0.5)

        assert _stands(waiting)
        for base in self.spec().of(BaseSpec):
            driving = self._driven(cell, base, BaseTwist(base.max_linear / 4.0, 0.0), 0.5)
            assert driving.linear > 0.0

    def test_a_halted_gripper_keeps_what_it_has(self, cell: CellDriver) -> None:
        for gripper in self._each(GripperSpec):
            cell.exchange({gripper.id: GripperTarget(gripper.max_gap / 2.0, gripper.max_force / 2.0)})
            before = _after(cell, 2.0).state(gripper.id, GripperState)
            cell.halt()
            opened = {gripper.id: GripperTarget(gripper.max_gap, gripper.max_force)}
            for _ in range(int(1.0 / cell.period)):
                cell.exchange(opened)

            assert cell.read().state(gripper.id, GripperState).gap == pytest.approx(before.gap, abs=self.gap_tolerance)

    # ------------------------------------------------------------------ cameras, end

    def test_a_picture_shows_the_cycle_in_which_it_was_asked_for(self, cell: CellDriver) -> None:
        if not self.pictures:
            pytest.skip("it takes no pictures")
        for robot in self.spec().robots:
            for camera in robot.of(CameraSpec):
                now = _after(cell, 0.1)
                pending = cell.capture(camera.id)
                _after(cell, 0.1)
                picture = check_pending(pending)

                assert pending.latency == pytest.approx(camera.latency, abs=1e-9)
                assert picture.snapshot == now
                assert picture.depth.shape == (camera.height, camera.width)
                assert picture.colour.shape == (camera.height, camera.width, 3)

    def test_a_camera_that_is_not_there_is_refused(self, cell: CellDriver) -> None:
        with pytest.raises(DeviceError, match="unknown_camera"):
            cell.capture("unknown_camera")

    def test_it_may_be_closed_twice(self, cell: CellDriver) -> None:
        cell.close()
        cell.close()

    # ------------------------------------------------------------------ how the robot is moved

    def _each(self, kind: type[SpecT]) -> tuple[SpecT, ...]:
        return self.spec().of(kind) or pytest.skip("the robot has no such device")

    def _run(self, cell: CellDriver, seconds: float) -> Snapshot:
        """Moves everything that can move: bases ahead, arms back and forth around where they are."""
        start = cell.read()
        for cycle in range(1, round(seconds / cell.period) + 1):
            cell.exchange(self._moving(start, cycle * cell.period))
        return cell.read()

    def _moving(self, start: Snapshot, time: float = 0.0) -> Commands:
        bases = {base.id: BaseTwist(base.max_linear / 4.0, 0.0) for base in self.spec().of(BaseSpec)}
        arms = {arm: _set_point(state.positions, time / _SWING) for arm, state in start.of(ArmState).items()}
        return {**arms, **bases}

    def _swing(self, cell: CellDriver, arm: str, start: tuple[float, ...], share: float) -> None:
        """Moves an arm from rest to rest by a little, or only for a share of that motion."""
        for cycle in range(1, round(share * _SWING / cell.period) + 1):
            cell.exchange({arm: _set_point(start, cycle * cell.period / _SWING)})

    def _driven(self, cell: CellDriver, base: BaseSpec, twist: BaseTwist, seconds: float) -> BaseState:
        for _ in range(round(seconds / cell.period)):
            cell.exchange({base.id: twist})
        return cell.read().state(base.id, BaseState)


_SWING = 1.0
"""Time of an arm's test motion [s]."""
_REACH = 0.1
"""How far each joint moves in it [rad]."""


def _set_point(start: tuple[float, ...], share: float) -> ArmTarget:
    """A motion from rest to rest along a half wave; back and forth where the share is above 1."""
    way, speed = (1.0 - math.cos(math.pi * share)) / 2.0, math.pi * math.sin(math.pi * share) / 2.0 / _SWING
    count = len(start)
    return ArmTarget(tuple(angle + _REACH * way for angle in start), (_REACH * speed,) * count)


def _after(cell: CellDriver, seconds: float) -> Snapshot:
    """Lets so much time pass without a command."""
    for _ in range(math.ceil(seconds / cell.period - 1e-6)):
        cell.exchange(_NOTHING)
    return cell.read()


def _stands(now: Snapshot) -> bool:
    arms, bases = now.of(ArmState), now.of(BaseState)
    return all(arm.still for arm in arms.values()) and all(base.still for base in bases.values())


def _in_thread(call: Callable[[], None]) -> None:
    thread = threading.Thread(target=call)
    thread.start()
    thread.join(timeout=10.0)
