"""A robot that nothing moves works at what its arm reaches from where it stands; the rest is refused with a reason."""

from __future__ import annotations

import pytest

from skiros_py.geometry import Pose
from skiros_py.station.session import Options, Session
from skiros_py.world.poses import write_pose

GOAL = "ObjectAtLocation(Starter, kit_1_a)"


def test_a_plan_of_a_cell_has_no_drive() -> None:
    with Session("kitting_cell", Options(fake=True)) as session:
        report = session.run()

    assert report.reached
    assert {step.skill for step in report.steps} == {"pick", "place"}


@pytest.mark.parametrize("place", ["pallet_a", "kit_1"])
def test_what_is_beyond_the_reach_of_a_cell_is_not_planned_and_the_figures_are_said(place: str) -> None:
    with Session("kitting_cell", Options(fake=True)) as session:
        with session.world.transaction("test", "moved away") as tx:
            write_pose(tx, place, Pose((0.0, 1.6, 0.0)))
        report = session.run([GOAL])

    assert not report.reached
    assert report.steps == ()
    assert f"{place} is 1.60 m from robot_1, which reaches 1.15 m" in report.conditions[0].reason


@pytest.mark.parametrize("scene", ["kitting", "kitting_two", "kitting_carried"])
def test_robots_with_a_base_drive_to_where_they_work(scene: str) -> None:
    with Session(scene, Options(fake=True)) as session:
        reached = [
            (robot, place)
            for robot in session.world.instances("sk:Robot")
            for place in session.world.instances("sk:Location")
            if session.world.related(robot, "sk:reaches", place)
        ]

    assert reached == []
