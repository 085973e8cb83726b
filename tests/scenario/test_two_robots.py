"""Two robots in one hall, in physics: they share the work and the floor, and never touch each other."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import pytest

from skiros_py.runtime import Session
from skiros_py.simulation.truth import Truth
from skiros_py.skills.outcome import Failure, Success

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


def test_two_robots_whose_ways_cross_wait_for_each_other_and_both_arrive(open_session: Callable[..., Session]) -> None:
    session = open_session("kitting_two", seed=1)
    truth, said = watched(session), []
    session.monitor.subscribe(lambda event: said.append(event.text))

    outcomes = run_side_by_side(
        session, ("drive", "base_1", {"Location": "pallet_c"}), ("drive", "base_2", {"Location": "pallet_a"})
    )

    assert all(isinstance(outcome, Success) for outcome in outcomes)
    assert any(text.startswith("waits for robot_") for text in said)
    assert touches(truth) == []


def test_a_robot_that_is_never_let_past_gives_up_with_a_reason(open_session: Callable[..., Session]) -> None:
    session = open_session("kitting_two", seed=2)
    run_side_by_side(session, ("drive", "base_1", {"Location": "pallet_a"}))

    outcome = session.run_module("drive_base", {"base": "base_2", "robot": "robot_2", "location": "pallet_a"}, "base_2")

    assert isinstance(outcome, Failure)
    assert "robot_1" in outcome.reason
    assert session.cycle.board.still


def test_a_place_that_another_robot_stands_at_is_not_driven_to(open_session: Callable[..., Session]) -> None:
    session = open_session("kitting_two", seed=2)
    run_side_by_side(session, ("drive", "base_1", {"Location": "kit_1_north"}))

    outcome = session.run_module("drive", {"Location": "kit_1_north"}, "base_2")

    assert isinstance(outcome, Failure)
    assert "kit_1_north" in outcome.reason


def test_the_truth_tells_when_two_robots_touch(open_session: Callable[..., Session]) -> None:
    session = open_session("kitting_two", seed=0)
    truth = watched(session)
    one = session.simulation.scene.robots[0]
    for joint, value in zip(one.joints.indices(("base_x", "base_y")), (-2.2, -0.7), strict=True):
        session.simulation.scene.client.resetJointState(one.body, joint, value)

    for _ in range(10):
        session.cycle.step()

    assert touches(truth)
