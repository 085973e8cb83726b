"""Robots that meet in a lane too narrow for two, in physics: one gives way, or they say why not."""

from __future__ import annotations

from dataclasses import replace

import pytest
from lanes import EAST, WEST, Lane, Traveller, head_on, meet, pass_through

from skiros_py.skills.outcome import OBSTRUCTED, Failure, Success
from skiros_py.station.session import Session

pytestmark = pytest.mark.physics

ROBOTS = Traveller(-1.0, 0.0, EAST), Traveller(1.0, 0.0, WEST)


def test_of_two_robots_head_on_one_gives_way_and_both_arrive_without_touching() -> None:
    met = meet(head_on(0), seed=0)

    assert met.stood <= 10.0
    assert len(set(met.gave_way)) == 1
    assert all(isinstance(outcome, Success) for outcome in met.outcomes)
    assert met.touches == ()


def test_where_no_robot_has_room_to_give_way_both_say_so_within_ten_seconds() -> None:
    met = meet(Lane(4.0, 1.5, (1.5, 1.5), ROBOTS, (0, 1)), seed=0)

    assert met.lasted <= 10.0
    for outcome, other in zip(met.outcomes, ("robot_2", "robot_1"), strict=True):
        assert isinstance(outcome, Failure)
        assert (outcome.code, outcome.values["blocked_by"]) == (OBSTRUCTED, [other])
    assert "there is no room to give way" in "".join(one.reason for one in met.outcomes if isinstance(one, Failure))


def test_a_robot_that_nothing_runs_on_is_reported_within_ten_seconds() -> None:
    idle = replace(ROBOTS[1], waits=True)
    met = meet(Lane(4.0, 1.5, (4.0, 4.0), (ROBOTS[0], idle), (0,)), seed=0)

    assert met.lasted <= 15.0  # stowing the arm included
    assert met.stood <= 10.0
    assert isinstance(met.outcomes[0], Failure)
    assert met.outcomes[0].values == {"blocked_by": ["robot_2"], "cause": "idle"}


def test_if_the_robot_that_gives_way_is_stopped_the_other_one_reports_it() -> None:
    stopped: list[float] = []

    def stop(session: Session, time: float) -> None:
        if not stopped and session.runtime.context.floor.is_driving("robot_2"):
            stopped.append(time)
            session.managers["base_2"].stop()

    met = meet(Lane(8.0, 1.5, (4.0, 4.0), ROBOTS, (0, 1)), seed=0, disturb=stop)

    assert stopped
    assert isinstance(met.outcomes[0], Failure)
    assert met.outcomes[0].values["blocked_by"] == ["robot_2"]
    assert met.lasted - stopped[0] <= 12.0


def test_a_robot_drives_through_a_passage_in_which_it_cannot_turn_without_touching_it() -> None:
    passing = pass_through(1)

    assert isinstance(passing.outcome, Success)
    assert passing.touches == ()
