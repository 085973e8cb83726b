"""Two robots in one hall, in physics: they share the work and the floor, and never touch each other."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import pytest

from skiros_primitives.arm_moves import ArmPrimitive
from skiros_py.catalogue import load_catalogue
from skiros_py.devices.arm import ArmState
from skiros_py.geometry import Pose
from skiros_py.ports.motion import PoseMove
from skiros_py.ports.paths import BaseLeg, BasePath
from skiros_py.simulation.truth import Truth
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.station.session import Options, Session

pytestmark = pytest.mark.physics


def watched(session: Session) -> Truth:
    """Notes in every fifth cycle what the robots touch."""
    truth = Truth(session.simulation)
    session.cycle.observe(lambda: truth.watch() if session.cycle.board.snapshot.cycle % 5 == 0 else None)
    return truth


def touches(truth: Truth) -> list[tuple[str, str]]:
    return [pair for pair in truth.worst if pair[1].startswith("robot_")]


def run_side_by_side(session: Session, *calls: tuple[str, str, Mapping[str, Any]]) -> list[Any]:
    """Starts modules of different subsystems in one cycle, and returns how they ended."""
    running = [session.start_module(module, arguments, agent) for module, agent, arguments in calls]
    while not all(one.done for one in running):
        session.cycle.step()
    return [one.result for one in running]


def test_four_parts_are_put_into_a_kit_from_two_sides(open_session: Callable[..., Session]) -> None:
    session = open_session("kitting_two", seed=0)
    truth = watched(session)

    report = session.run()

    assert report.reached
    assert [c.true for c in report.conditions] == [True] * 4
    assert {step.arguments["Robot"] for step in report.steps} == {"robot_1", "robot_2"}
    assert touches(truth) == []


def test_two_robots_on_crossing_paths_wait_for_each_other_and_both_arrive(open_session: Callable[..., Session]) -> None:
    session = open_session("kitting_two", seed=1)
    truth, said = watched(session), []
    session.monitor.subscribe(lambda event: said.append(event.text))

    outcomes = run_side_by_side(
        session, ("drive", "base_1", {"Location": "pallet_c"}), ("drive", "base_2", {"Location": "pallet_a"})
    )

    assert all(isinstance(outcome, Success) for outcome in outcomes)
    assert any(text.startswith("waits for robot_") for text in said)
    assert touches(truth) == []


def test_a_permanently_blocked_robot_gives_up_with_a_reason(open_session: Callable[..., Session]) -> None:
    session = open_session("kitting_two", seed=2)
    run_side_by_side(session, ("drive", "base_1", {"Location": "pallet_a"}))

    outcome = session.run_module("drive_base", {"base": "base_2", "robot": "robot_2", "location": "pallet_a"}, "base_2")

    assert isinstance(outcome, Failure)
    assert "robot_1" in outcome.reason
    assert session.cycle.board.still


def test_a_robot_does_not_drive_to_an_occupied_place(open_session: Callable[..., Session]) -> None:
    session = open_session("kitting_two", seed=2)
    run_side_by_side(session, ("drive", "base_1", {"Location": "kit_1_north"}))

    outcome = session.run_module("drive", {"Location": "kit_1_north"}, "base_2")

    assert isinstance(outcome, Failure)
    assert "kit_1_north" in outcome.reason


class Reach(ArmPrimitive):
    """Stretches an arm out."""

    name: ClassVar[str] = "reach"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        arm: str = param("sk:Arm", "The arm.", kind=Kind.HARDWARE)
        tip: Pose = param("pose", "Where to, in the map.")

    def execute(self) -> Execution[Outcome]:
        """Moves."""
        refusal = yield from self.go([(PoseMove(self.params.tip),)])
        return Success() if refusal is None else Failure(refusal.reason)


OUTLINE = ((-0.3, -0.3), (0.3, -0.3), (0.3, 0.3), (-0.3, 0.3))
ASIDE = Pose((-1.98, -0.55, 0.6), (1.0, 0.0, 0.0, 0.0))
"""Left of where robot 2 starts, with the hand pointing down."""


@pytest.fixture
def reaching() -> Iterator[Session]:
    """A session in which arms can be stretched out."""
    catalogue = load_catalogue()
    catalogue = replace(catalogue, primitives={**catalogue.primitives, Reach.name: Reach})
    with Session("kitting_two", Options(seed=0), catalogue=catalogue) as session:
        yield session


def test_an_arm_waits_for_a_robot_driving_in_its_reach_and_then_blocks_the_floor_itself(reaching: Session) -> None:
    session = reaching
    floor, board = session.runtime.context.floor, session.cycle.board
    past = BasePath((BaseLeg(2.0, 0.0),), 0.0)
    arm = [board.snapshot.state("arm_2", ArmState).positions]

    with floor.ask("robot_1", OUTLINE, Pose((-4.0, -0.4, 0.0)), past) as way:
        assert way.free
        running = session.start_module("reach", {"tip": ASIDE}, "arm_2")
        for _ in range(400):
            session.cycle.step()
        arm.append(board.snapshot.state("arm_2", ArmState).positions)
    while not running.done:
        session.cycle.step()

    assert running.result == Success()
    assert arm[1] == pytest.approx(arm[0], abs=0.01)
    assert board.snapshot.state("arm_2", ArmState).positions != pytest.approx(arm[0], abs=0.2)
    with floor.ask("robot_1", OUTLINE, Pose((-4.0, -0.4, 0.0)), past) as way:
        assert (way.free, way.blocked, way.waits_for()) == (False, True, ("robot_2",))


def test_the_simulator_reports_contacts_between_two_robots(open_session: Callable[..., Session]) -> None:
    session = open_session("kitting_two", seed=0)
    truth = watched(session)
    session.simulation.scene.robots[0].model.joints(("base_x", "base_y")).reset((-2.2, -0.7))

    for _ in range(10):
        session.cycle.step()

    assert touches(truth)
