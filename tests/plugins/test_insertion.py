"""A part that stands on a wall finds its way down by feel, within bounds."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.stepping import run

from skiros_primitives.contact import HandForce
from skiros_primitives.insertion import REACH, Insertion, away, shake, spiral
from skiros_primitives.playback import moved_to
from skiros_py.devices.arm import ArmTarget
from skiros_py.devices.force_torque import ForceTorqueSpec, ForceTorqueState
from skiros_py.geometry import Pose
from skiros_py.ports.motion import Trajectory

PERIOD = 0.005
STIFFNESS = 20_000.0
WALL, PLAY = 0.02, 0.0015
JOINTS = ("x", "y", "z", "rx", "ry", "rz")
ARM = SimpleNamespace(id="arm_1", joints=JOINTS, tip="tip")
SENSOR = ForceTorqueSpec("sensor_1", "arm_1", "rz", "flange")
FLANGE = 0.1


class Hand:
    """A hand whose joints are the axes of the base: it holds a part over an opening among walls.

    Args:
        x: Where the opening is, from below the hand [m].
        y: The same.
        floor: Height of the floor in it [m].
    """

    def __init__(self, x: float, y: float, floor: float = 0.0) -> None:
        self.id, self.spec = "arm_1", ARM
        self.opening, self.floor = (x, y), floor
        self.at = np.array([0.0, 0.0, WALL + 0.001, 0.0, 0.0, 0.0])
        self.highest, self.way, self.cycles = 0.0, [self.at], 0
        self.context: Any = SimpleNamespace(
            board=self,
            port=lambda *_: self,
            ports=SimpleNamespace(find=lambda *_: self),
            cell=SimpleNamespace(group_of=lambda _: SimpleNamespace(of=lambda _: (SENSOR,))),
        )
        self.period, self.devices = PERIOD, {"sensor_1": SENSOR}
        self.snapshot = self
        self.guard = SimpleNamespace(require=lambda _: None)
        self.is_up = True

    # the arm

    @property
    def state(self) -> Any:
        speed = (self.at - self.way[-2]) / PERIOD if self.cycles else np.zeros(6)
        return SimpleNamespace(positions=tuple(self.at.tolist()), velocities=tuple(speed.tolist()), still=True)

    @property
    def time(self) -> float:
        return self.cycles * PERIOD

    def command(self, target: ArmTarget) -> None:
        self.at = np.array(target.positions)
        self.cycles += 1
        self.way.append(self.at)
        self.highest = max(self.highest, self.force()[2])

    # its kinematics

    def pose(self, link: str, positions: dict[str, float]) -> Pose:
        x, y, z, *_ = (positions[name] for name in JOINTS)
        return Pose((x, y, z + (FLANGE if link == "flange" else 0.0)))

    def jacobian(self, *_: Any) -> Any:
        return np.eye(6)

    # the board and its snapshot

    def require_open(self, _: str) -> None:
        pass

    def force(self) -> tuple[float, float, float]:
        aside = np.abs(self.at[:2] - self.opening)
        support = self.floor if (aside <= PLAY).all() else WALL
        if self.at[2] < WALL and support == WALL and self.way[-2][2] < WALL - 0.003:  # it is inside: walls hold it
            self.at = np.array([*np.clip(self.at[:2], *np.add.outer((-PLAY, PLAY), self.opening)), *self.at[2:]])
            support = self.floor
        return 0.0, 0.0, max(0.0, STIFFNESS * (support - self.at[2]))

    def says(self) -> ForceTorqueState:
        """It is pushed up where the wall is: on the side away from the opening."""
        up = self.force()[2]
        beside = -0.03 * np.sign(self.opening)
        return ForceTorqueState((0.0, 0.0, up), (float(beside[1]) * up, -float(beside[0]) * up, 0.0))


@pytest.fixture(autouse=True)
def sensor(monkeypatch: pytest.MonkeyPatch) -> None:
    """The sensor says what pushes the hand."""

    class Handle:
        def __class_getitem__(cls, _: Any) -> Any:
            return cls

        def __init__(self, board: Any, _: str) -> None:
            self._board = board

        @property
        def state(self) -> ForceTorqueState:
            said: ForceTorqueState = self._board.says()
            return said

    monkeypatch.setattr("skiros_primitives.contact.DeviceHandle", Handle)


def inserted(hand: Hand, way: Callable[[Insertion], Any] = Insertion.search) -> Any:
    force = HandForce.of(hand.context, hand)  # type: ignore[arg-type]
    assert force is not None
    run(force.weigh())
    return run(way(Insertion(hand.context, hand, force, 0.0, 0.004)))  # type: ignore[arg-type]


def test_a_part_that_stands_on_a_wall_is_moved_to_where_it_goes_in() -> None:
    for turn in np.linspace(0.0, math.tau, 9):
        hand = Hand(0.003 * math.cos(turn), 0.003 * math.sin(turn))

        assert inserted(hand)
        assert hand.at[2] < 0.004
        assert hand.highest < 40.0


def test_it_is_moved_away_from_where_it_is_pushed_up_first() -> None:
    near, far = Hand(0.003, 0.0), Hand(0.003, 0.0)
    far.says = lambda: ForceTorqueState((0.0, 0.0, far.force()[2]))  # type: ignore[method-assign]  # no torque

    assert inserted(near)
    assert inserted(far)
    assert near.cycles < 0.7 * far.cycles


def test_where_there_is_no_opening_it_ends_and_has_pushed_nothing_far_or_hard() -> None:
    hand = Hand(0.02, 0.0)

    assert not inserted(hand)
    assert np.abs(np.array(hand.way)[:, :2]).max() <= REACH + 1e-4
    assert hand.cycles * PERIOD < 8.0
    assert hand.highest < 40.0


def test_a_shake_ends_where_it_began() -> None:
    steps = list(shake(PERIOD))

    assert 1.0 < len(steps) * PERIOD < 3.0
    assert max(abs(step.turn) for step in steps) < math.radians(3.0)
    assert (steps[-1].x, steps[-1].y, steps[-1].turn) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


def test_a_spiral_leaves_nothing_out() -> None:
    places = np.array([(step.x, step.y) for step in spiral(PERIOD)])

    for radius in (0.0, 0.001, 0.0025, 0.0034):
        for turn in np.linspace(0.0, math.tau, 20):
            wanted = radius * math.cos(turn), radius * math.sin(turn)
            assert np.hypot(*(places - wanted).T).min() < 0.0006


def test_away_goes_to_the_other_side_and_back() -> None:
    steps = list(away(np.array([0.02, 0.0]), PERIOD))

    assert min(step.x for step in steps) == pytest.approx(-REACH, abs=1e-4)
    assert steps[-1].x == pytest.approx(0.0)


def test_lowered_where_something_is_below_it_does_not_stand_on_the_floor() -> None:
    assert not inserted(Hand(0.02, 0.0), Insertion.lower)
    assert inserted(Hand(0.0, 0.0, 0.002), Insertion.lower)


def test_a_motion_that_begins_elsewhere_comes_to_its_own_way_without_a_jump() -> None:
    positions = np.linspace(0.0, 0.5, 101)[:, None]
    way = Trajectory(positions, np.full((101, 1), 0.005 / PERIOD))

    moved = moved_to(way, (0.02,), PERIOD)

    assert moved.positions[0] == pytest.approx(0.02)
    assert moved.positions[-1] == pytest.approx(0.5)
    assert np.abs(np.diff(moved.positions[:, 0])).max() < 0.006
    assert np.gradient(moved.positions[:, 0], PERIOD)[1:-1] == pytest.approx(moved.velocities[1:-1, 0], abs=1e-3)


def test_a_heavy_hand_that_speeds_up_is_pushed_by_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    held, hand, before = 2.0, Hand(0.0, 0.0), [0.0, 0.0]
    heavy = replace(SENSOR, mass=5.0, centre=(0.0, 0.0, 0.05))
    monkeypatch.setattr(hand, "devices", {"sensor_1": heavy})

    def says() -> ForceTorqueState:
        """It feels the weight of what is held, and what its own mass and that take to be sped up."""
        down = (heavy.mass + held) * (before[1] - before[0]) / PERIOD
        return ForceTorqueState((0.0, 0.0, hand.force()[2] - down - held * 9.81))

    hand.says = says  # type: ignore[method-assign]
    force = HandForce(hand.context, hand, heavy)  # type: ignore[arg-type]
    run(force.weigh())
    felt = []
    for cycle in range(40):
        before = [before[1], -1.5 * PERIOD * min(cycle, 10)]
        below = hand.at + np.array([0.0, 0.0, before[1] * PERIOD, 0.0, 0.0, 0.0])
        hand.command(ArmTarget(tuple(below.tolist()), (0.0,) * 6))
        felt.append(float(force.push()[2]))

    assert hand.at[2] < WALL, "it came down into the opening"
    assert np.abs(felt).max() < 0.5
