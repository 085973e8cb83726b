"""An arm feels contacts in what its joints exert, also while its base speeds up or brakes."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from skiros_primitives.contact import ContactWatch
from skiros_py.devices.arm import ArmState
from skiros_py.devices.mobile_base import BaseState
from skiros_py.geometry import Array, Pose
from skiros_py.ports.kinematics import JointMotion, JointRange

INERTIA, LEVER, PERIOD = 2.0, 10.0, 0.005


class Robot:
    """What ContactWatch asks for: an arm of one joint, which the base loads when it speeds up."""

    id = tip = "arm"
    parents: dict[str, str] = {}  # noqa: RUF012 - a link on the base

    def __init__(self, braking: float, *, effort: float = 87.0) -> None:
        self.braking = braking
        self.joints = {"joint": JointRange(None, None, None, effort)}  # names for the arm, ranges for its kinematics
        self.speed = 0.4
        self.moving = 0.0
        self.exerted = 0.0
        self.time = 0.0
        self.spec = self
        self.board: Any = SimpleNamespace(period=PERIOD, snapshot=self, stand=lambda _devices: not braking)
        self.cell = SimpleNamespace(group_of=lambda _device: self)
        self.carrier = SimpleNamespace(id="base")

    def port(self, _protocol: Any, _device: str) -> Robot:
        return self

    def of(self, _kind: type) -> list[Robot]:
        return [self]

    @property
    def devices(self) -> dict[str, BaseState]:
        return {"base": BaseState(Pose(), self.speed if self.braking else 0.0, 0.0, still=not self.braking)}

    @property
    def state(self) -> Any:
        return _State(self)

    def efforts(self, motion: JointMotion) -> Array:
        ahead, aside, around, joint = motion.accelerations
        return np.array([0.0, aside, around, LEVER * ahead + INERTIA * joint])

    def pose(self, _link: str, _positions: Any) -> Pose:
        return Pose()

    def jacobian(self, _link: str, _positions: Any, joints: Any) -> Array:
        return np.zeros((6, len(joints)))

    def felt(self, *, pushed: float = 0.0, knocked: bool = False, cycles: int = 50) -> bool:
        """Moves the arm for half a second while the base brakes, from the second half on against something.

        Where the base is knocked, it stops dead then.
        """
        watch, felt = ContactWatch(self, self), False  # type: ignore[arg-type]
        for cycle in range(100):
            self.time += PERIOD
            braking = 0.0 if knocked and cycle >= 50 else self.braking
            self.speed = self.speed - braking * PERIOD if braking or not knocked else 0.0
            self.moving += 1.5 * PERIOD
            self.exerted = -LEVER * braking + INERTIA * 1.5 + (pushed if 50 <= cycle < 50 + cycles else 0.0)
            felt = watch.felt() is not None or felt
        return felt


class _State(ArmState):
    """The state of the arm now; called with a device and a kind as of a snapshot."""

    def __init__(self, robot: Robot) -> None:
        super().__init__((0.0,), (robot.moving,), still=False, efforts=(robot.exerted,))

    def __call__(self, _device: str, _kind: type) -> ArmState:
        return self


def test_a_base_that_brakes_is_no_contact_of_its_arm() -> None:
    assert not Robot(0.0).felt()
    assert not Robot(0.5).felt()


def test_what_an_arm_meets_is_felt_while_its_base_brakes() -> None:
    assert Robot(0.0).felt(pushed=6.0)
    assert Robot(0.5).felt(pushed=6.0)


def test_an_arm_that_swings_as_its_base_is_knocked_has_met_nothing() -> None:
    assert not Robot(0.5).felt(pushed=6.0, knocked=True, cycles=30)
    assert Robot(0.5).felt(pushed=6.0, knocked=True, cycles=50), "what presses on afterwards is felt"


def test_a_joint_feels_from_1_percent_of_what_it_exerts_on_but_a_weak_one_from_4() -> None:
    assert [Robot(0.0, effort=12.0).felt(pushed=push) for push in (3.9, 4.1)] == [False, True]
    assert [Robot(0.0, effort=400.0).felt(pushed=push) for push in (3.9, 4.1)] == [False, True]
    assert [Robot(0.0, effort=3000.0).felt(pushed=push) for push in (29.0, 31.0)] == [False, True]
