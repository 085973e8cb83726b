"""Robots of several kinds with one goal: a part that only one of them reaches goes by way of a shelf."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from skiros_py.station.session import Options, Session
from skiros_py.tasks.report import GoalReport


@pytest.fixture
def session() -> Iterator[Session]:
    with Session("kitting_all", Options(fake=True)) as session:
        yield session


def steps(report: GoalReport, part: str) -> list[tuple[str, str]]:
    """Returns who did what with a part."""
    return [(s.skill, s.arguments["Robot"]) for s in report.steps if s.arguments.get("Object") == part]


def test_a_part_that_only_mobile_robots_reach_comes_into_a_kit_that_only_the_cell_reaches(session: Session) -> None:
    report = session.run(["ObjectAtLocation(starter_1, kit_1_a)"])

    assert report.reached
    (pick, brings), (hand_over, gives), *rest = steps(report, "starter_1")
    assert (pick, hand_over) == ("pick", "hand_over")
    assert brings == gives != "robot_3"
    assert rest == [("pick", "robot_3"), ("place", "robot_3")]


def test_a_part_that_only_the_cell_reaches_comes_into_a_kit_that_only_mobile_robots_reach(session: Session) -> None:
    report = session.run(["ObjectAtLocation(relay_box_1, kit_2_b)"])

    assert report.reached
    assert steps(report, "relay_box_1")[:2] == [("pick", "robot_3"), ("hand_over", "robot_3")]
    (pick, takes), (place, puts) = steps(report, "relay_box_1")[2:]
    assert (pick, place) == ("pick", "place")
    assert takes == puts != "robot_3"


def test_what_one_robot_can_do_alone_is_not_handed_over(session: Session) -> None:
    goal = ["ObjectAtLocation(compressor_1, kit_1_b)", "ObjectAtLocation(alternator_1, kit_2_a)"]

    report = session.run(goal)

    assert report.reached
    assert {step.skill for step in report.steps} == {"drive", "pick", "place"}
    assert steps(report, "compressor_1") == [("pick", "robot_3"), ("place", "robot_3")]


def test_the_goal_of_the_whole_scene_is_reached(session: Session) -> None:
    report = session.run()

    assert report.reached
    assert [step.arguments["Object"] for step in report.steps if step.skill == "hand_over"].count("starter_1") == 1


def test_without_the_shelf_there_is_no_plan(session: Session) -> None:
    with session.world.transaction("test", "taken away") as tx:
        tx.remove("shelf_1")

    report = session.run(["ObjectAtLocation(starter_1, kit_1_a)"])

    assert not report.reached
    assert report.steps == ()
