"""Robots of several kinds in one hall: a part goes by way of a shelf to the robot that reaches the kit."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from skiros_py.simulation.truth import Truth
from skiros_py.station.session import Session

pytestmark = pytest.mark.physics


def test_a_mobile_robot_brings_a_part_to_a_shelf_and_the_cell_puts_it_into_its_kit(
    open_session: Callable[..., Session],
) -> None:
    session = open_session("kitting_all", seed=3)
    truth = Truth(session.simulation)
    session.cycle.observe(lambda: truth.watch() if session.cycle.board.snapshot.cycle % 5 == 0 else None)

    report = session.run(["ObjectAtLocation(starter_1, kit_1_a)"])

    assert report.reached
    assert [(one.believed, one.true) for one in report.conditions] == [(True, True)]
    done = [(step.skill, step.arguments["Robot"]) for step in report.steps if not step.reason]
    assert done[-2:] == [("pick", "robot_3"), ("place", "robot_3")]
    assert "hand_over" in dict(done[:-2])
    assert [pair for pair in truth.worst if pair[1].startswith("robot_")] == []
