"""The goal that the paper shows in Fig. 5: an abstract alternator in Kit-9, and the robot at LargeBox-3."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from skiros_py.config import find_scene
from skiros_py.errors import UsageError
from skiros_py.planning.plan import Plan
from skiros_py.station.session import Options, Session

GOAL = "InKit(Alternator, kit_9) and RobotAtLocation(robot_1, large_box_3)"
BOXES = """
scene:large_box_3 a kitting:Box ; rdfs:label "LargeBox-3" ; sk:on scene:floor ;
    sk:pose "1.7 2.5 0 0 0 0"^^sk:poseLiteral ; sk:drivingPose "-1 0 0 0 0 0"^^sk:poseLiteral .
scene:large_box_4 a kitting:Box ; rdfs:label "LargeBox-4" ; sk:on scene:floor ;
    sk:pose "1.7 -2.5 0 0 0 0"^^sk:poseLiteral ; sk:drivingPose "-1 0 0 0 0 0"^^sk:poseLiteral .
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """The shipped scene, with the names of the figure and two large boxes more."""
    text = Path(find_scene("kitting")).read_text(encoding="utf-8").replace("kit_1", "kit_9")
    file = tmp_path / "figure_five.ttl"
    file.write_text(text + BOXES, encoding="utf-8")
    return file


@pytest.fixture
def session(scene: Path) -> Iterator[Session]:
    with Session(str(scene), Options(fake=True, goal=GOAL)) as opened:
        yield opened


def test_the_plan_puts_an_alternator_into_the_kit_and_ends_at_the_box(session: Session) -> None:
    outcome = session.plan().outcome

    assert isinstance(outcome, Plan)
    assert [step.skill for step in outcome.steps] == ["drive", "pick", "drive", "place", "drive"]
    assert outcome.steps[1].arguments["Object"] == "alternator_1"
    assert outcome.steps[3].arguments["Compartment"].startswith("kit_9_")
    assert outcome.steps[-1].arguments["Location"] == "large_box_3"


def test_the_robot_reaches_the_goal_of_figure_five(session: Session) -> None:
    report = session.run()

    assert report.reached
    assert session.world.related("robot_1", "sk:at", "large_box_3")
    (compartment,) = session.world.objects("alternator_1", "sk:in")
    assert session.world.related("kit_9", "sk:hasA", compartment)


def test_a_class_is_refused_where_a_box_of_the_scene_is_needed(scene: Path) -> None:
    needed = "Box is a class; RobotAtLocation needs one element of the scene: .*large_box_3"

    options = Options(fake=True, goal="RobotAtLocation(robot_1, Box)")
    with pytest.raises(UsageError, match=needed), Session(str(scene), options):
        pass
