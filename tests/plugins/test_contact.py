"""What an arm does where it meets something: it moves back the way it came, and believes only what it did not know."""

from __future__ import annotations

import math
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.stepping import run

from skiros_primitives import arm_moves
from skiros_primitives.arm_moves import ArmPrimitive
from skiros_primitives.contact import GENTLE, TOLERANCE, Touch
from skiros_py.devices.arm import ArmTarget
from skiros_py.devices.localiser import LocaliserSpec
from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose, Solid
from skiros_py.ports.motion import Held, MotionPlan, MotionRequest, NoMotion, Obstacle, Refusal, Trajectory
from skiros_py.ports.values import Done
from skiros_py.skills.context import Tried
from skiros_py.skills.outcome import Outcome, Success
from skiros_py.skills.pictures import Pictures
from skiros_py.skills.primitive import Execution

PERIOD = 0.005
SHARES = np.linspace(0.0, 1.0, 201)
WAY = Trajectory(
    np.column_stack([1.0 - np.cos(np.pi * SHARES), SHARES * 0.0]),
    np.column_stack([np.pi * np.sin(np.pi * SHARES), SHARES * 0.0]),
)
"""One joint turns by 2 rad in a second, from rest to rest."""
TYPES = {"shelf": "kitting:Pallet", "obstacle_1": "sk:Obstacle", "part": "kitting:Part", "deck_kit": "kitting:Kit"}


class World:
    """A shelf, something that was met before, a part, and a kit that the robot carries."""

    ontology = SimpleNamespace(
        is_a=lambda type_, class_: type_ == class_ or (type_, class_) == ("kitting:Part", "sk:Manipulatable")
    )

    version = 0

    def has(self, element: str) -> bool:
        return element in TYPES

    def element(self, element: str) -> SimpleNamespace:
        return SimpleNamespace(type=TYPES[element])

    def objects(self, element: str, _: str) -> list[str]:
        return ["base_1"] if element == "deck_kit" else []


class Moving(ArmPrimitive):
    """An arm that follows its targets exactly and meets something in one cycle."""

    name = "moving"
    Params = SimpleNamespace

    def __init__(self, touches: tuple[tuple[str, str], ...] = (), *, meets_at: int = 100) -> None:
        self.commands: list[ArmTarget] = []
        self.requests: list[MotionRequest] = []
        self.state = SimpleNamespace(positions=(0.0, 0.0), velocities=(0.0, 0.0), efforts=(0.0, 0.0), still=True)
        self.meets_at, self._touches = meets_at, touches
        context: Any = SimpleNamespace(
            now=0.0,
            lockstep=True,
            world=World(),
            tried=Tried(),
            board=SimpleNamespace(period=PERIOD, snapshot=SimpleNamespace(of=lambda _: {})),
            port=lambda *_: self,
            ports=SimpleNamespace(find=lambda *_: None),
            pictures=Pictures(),
            waiting=nullcontext,
            emit=lambda *_: None,
            rng=np.random.default_rng(0),
        )
        super().__init__(context, SimpleNamespace(arm="arm_1"))

    @property
    def arm(self) -> Any:
        return self

    def command(self, target: ArmTarget) -> None:
        self.commands.append(target)
        self.state.positions = target.positions
        self.context.now += PERIOD  # type: ignore[misc]

    @property
    def robot(self) -> Any:
        noise = LocaliserSpec("localiser_1", 0.005, math.radians(0.3))
        return SimpleNamespace(id="robot_1", of=lambda _: (noise,), has=lambda device: device == "base_1")

    @property
    def base_pose(self) -> Pose:
        return Pose()

    @property
    def gripper_id(self) -> str:
        return "gripper_1"

    @property
    def gripper_spec(self) -> Any:
        return SimpleNamespace(max_gap=0.08)

    def held(self) -> Held | None:
        return None

    def plan(self, request: Any, **_: Any) -> Any:
        """Stands for the planner: where the arm is, it would touch something."""
        self.requests.append(request)
        return Done(NoMotion("no", refusals=(Refusal(0, 0, "", "collision", "would touch", self._touches),)))

    def execute(self) -> Execution[Outcome]:
        yield
        return Success()

    def _left(self, trajectory: Trajectory) -> float:
        return 1.0

    spec = SimpleNamespace(tip="tcp", joints=("one", "two"))

    # ContactWatch

    touches_at_start = False
    end = (0.5, 0.0, 0.5)

    def felt(self) -> Touch | None:
        met = len(self.commands) == self.meets_at
        return Touch(9.0, "tcp", (0.5, 0.0, 0.5), self.end, (1.0, 0.0, 0.0), frozenset({"link_2"})) if met else None


@pytest.fixture(autouse=True)
def written(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What is believed to be in the way."""
    found: list[str] = []
    things = tuple(Obstacle(name, Solid.box(1.0, 1.0, 1.0), Pose()) for name in TYPES)
    monkeypatch.setattr(arm_moves, "believe_obstacle", lambda *_: found.append("obstacle"))
    monkeypatch.setattr(arm_moves, "obstacles", lambda *_, **__: things)
    monkeypatch.setattr(arm_moves, "bodies", lambda *_: ())
    monkeypatch.setattr(arm_moves.ContactWatch, "of", lambda _context, arm, **_: arm)
    return found


def test_it_is_behind_the_contact_with_the_next_target_and_goes_back_to_where_it_began() -> None:
    arm = Moving()

    refusal = run(arm.follow(WAY))

    after = np.array([target.positions[0] for target in arm.commands[arm.meets_at :]])
    assert isinstance(refusal, NoMotion)
    assert refusal.met
    assert after[0] < arm.commands[arm.meets_at - 2].positions[0]
    assert arm.commands[arm.meets_at].velocities[0] < 0.0
    assert np.abs(np.diff(after)).max() <= 0.5 * np.abs(WAY.velocities).max() * PERIOD
    assert after[-1] == pytest.approx(WAY.positions[0, 0], abs=1e-3)


class Force:
    """What pushes the hand: nothing until a cycle, then something; or the sensor does not answer."""

    def __init__(self, arm: Moving, *, presses_at: int = 10_000, dies_at: int = 10_000) -> None:
        self._arm, self._presses_at, self._dies_at = arm, presses_at, dies_at

    def push(self) -> Any:
        if len(self._arm.commands) >= self._dies_at:
            raise DeviceError("sensor_1 was switched off")
        return np.array([0.0, 0.0, 6.0 if len(self._arm.commands) >= self._presses_at else 0.0])


def test_where_the_hand_presses_a_motion_ends_and_the_hand_stays(written: list[str]) -> None:
    arm = Moving(meets_at=10_000)

    refusal = run(arm.follow(WAY, landing=0.0, force=Force(arm, presses_at=60)))  # type: ignore[arg-type]

    assert refusal is not None
    assert refusal.met
    assert arm.commands[-1].positions[0] == pytest.approx(WAY.positions[60, 0], abs=0.05)
    assert not written
    assert run(arm.follow(WAY, landing=2.0, force=Force(arm, presses_at=0))) is None  # type: ignore[arg-type]


def test_a_sensor_that_does_not_answer_is_said_and_the_joints_feel_contact_as_gently(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    arm, said = Moving(), list[str]()
    arm.tolerance = TOLERANCE  # type: ignore[attr-defined]
    monkeypatch.setattr(Moving, "progress", lambda _self, _code, text: said.append(text))

    refusal = run(arm.follow(WAY, landing=0.0, tolerance=GENTLE, force=Force(arm, dies_at=50)))  # type: ignore[arg-type]

    assert said == ["sensor_1 was switched off: the joints of arm_1 feel contact"]
    assert arm.tolerance == GENTLE  # type: ignore[attr-defined]
    assert refusal is not None
    assert refusal.met


def test_near_to_things_it_moves_back_a_little_and_the_line_up_is_followed_afterwards() -> None:
    arm = Moving()

    run(arm.follow(WAY, landing=0.0))

    here = arm.commands[arm.meets_at - 1].positions[0]
    assert 0.5 * here < arm.commands[-1].positions[0] < here


def test_a_contact_where_something_may_be_that_is_known_is_no_unknown_thing(written: list[str]) -> None:
    arm = Moving((("hand", "shelf"),))

    refusal = run(arm.follow(WAY))

    assert not written
    assert "shelf" in refusal.reason


@pytest.mark.parametrize("touches", [(), (("link_2", "shelf"),), (("hand", "obstacle_1"),)])
def test_a_contact_that_nothing_explains_is_believed_to_be_an_obstacle(
    touches: tuple[tuple[str, str], ...], written: list[str]
) -> None:
    """Neither does a shelf near to a link that is not touched, nor what was met before."""
    run(Moving(touches).follow(WAY))

    assert written == ["obstacle"]


def test_what_a_hand_has_met_may_be_anywhere_along_it(monkeypatch: pytest.MonkeyPatch) -> None:
    found: list[tuple[Any, ...]] = []
    monkeypatch.setattr(arm_moves, "believe_obstacle", lambda *args: found.append(args))
    arm = Moving()
    arm.end = (0.5, 0.0, 0.7)

    run(arm.follow(WAY))

    ((_, _, pose, size, _),) = found
    assert pose.position == pytest.approx((0.6, 0.0, 0.45))
    assert size == pytest.approx((0.1, 0.1, 0.3))


def test_things_are_as_far_off_as_the_localiser_errs_but_what_it_sees_or_carries_is_not() -> None:
    arm = Moving((("hand", "shelf"),))

    run(arm.follow(WAY))
    arm.meets_at = 0
    run(arm._planned([], 1.0))

    first, second = ({one.id: one.error for one in request.obstacles} for request in arm.requests)
    usual = 3.0 * math.hypot(0.005, 0.9 * math.radians(0.3))
    assert first == {"shelf": pytest.approx(usual), "obstacle_1": 0.0, "part": 0.0, "deck_kit": 0.0}
    assert second["shelf"] == pytest.approx(2.0 * usual)


def test_from_elsewhere_it_comes_to_a_trajectory_without_a_jump() -> None:
    arm = Moving(meets_at=-1)
    arm.state.positions = (0.3, 0.4)

    run(arm.follow_from_here(WAY))

    places = np.array([(0.3, 0.4), *(target.positions for target in arm.commands)])
    assert np.abs(np.diff(places, axis=0)).max() <= np.abs(WAY.velocities).max() * PERIOD * 1.01
    assert places[-1] == pytest.approx(WAY.positions[-1])


def test_a_way_down_that_is_broken_off_is_left_along_itself() -> None:
    """The way up leads through other postures: the arm would jump to it."""
    recovered: list[Trajectory] = []

    class Handling(Moving, arm_moves.HandlingPrimitive):
        def recover(self) -> Execution[None]:
            assert self.retreat is not None
            recovered.append(self.retreat)
            yield from ()

        def progress(self, code: int, text: str) -> None:
            pass

    arm = Handling(meets_at=250)
    up = Trajectory(WAY.positions[::-1] + 0.5, -WAY.velocities[::-1])
    further = Trajectory(WAY.positions + 2.0, WAY.velocities)

    refusal = run(arm.come_down(MotionPlan(0, (WAY, further, up)), landing=0.0))

    assert isinstance(refusal, NoMotion)
    assert recovered[0].positions == pytest.approx(further.positions[::-1])
