"""A session with a hand-made catalogue: the tiny domain from a scene file, without any installed plug-in's skills."""

from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.catalogue import Catalogue
from skiros_py.errors import UnknownName, UsageError
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.plugins.plugin import PluginFault
from skiros_py.station.session import Options, Session
from skiros_py.testing import CONDITIONS, SKILLS, TINY_ONTOLOGY, tiny_scene

FAULT = PluginFault("skiros.skills", "fly", "drones 0.1", "ImportError: no wings", "Traceback …")


@pytest.fixture(autouse=True)
def _tiny(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SKIROS_ONTOLOGIES", str(TINY_ONTOLOGY))


def catalogue(*faults: PluginFault) -> Catalogue:
    skills = {skill.description.name: skill for skill in SKILLS}
    return Catalogue(skills, {}, CONDITIONS, {"fast-downward": FastDownward}, {}, faults)


def opened(scene: Path, **options: object) -> Session:
    return Session(str(scene), Options(fake=True, **options), catalogue=catalogue())  # type: ignore[arg-type]


def test_without_an_explicit_goal_the_goal_of_the_scene_is_pursued(tmp_path: Path) -> None:
    with opened(tiny_scene(tmp_path, goals=("In(ball_1, slot_1)",))) as session:
        report = session.run()

    assert report.reached


def test_a_goal_in_the_options_takes_precedence_over_the_goal_of_the_scene(tmp_path: Path) -> None:
    scene = tiny_scene(tmp_path, goals=("In(ball_1, slot_1)",))

    with opened(scene, goal=("At(robot_1, box_b)",)) as session:
        assert [str(condition) for condition in session.goal] == ["At(robot_1, box_b)"]


def test_running_a_scene_without_a_goal_asks_for_a_goal(tmp_path: Path) -> None:
    with opened(tiny_scene(tmp_path)) as session, pytest.raises(UsageError, match="comes without a goal: state one"):
        session.run()


def test_a_goal_may_be_given_as_text_or_as_conditions(tmp_path: Path) -> None:
    with opened(tiny_scene(tmp_path)) as session:
        assert session.run(["At(robot_1, box_a)"]).reached
        assert session.run(session.parse(["At(robot_1, box_b)"])).reached


@pytest.mark.parametrize("name", ["robot_2", "robot 2"])
def test_a_robot_is_chosen_by_id_or_label_and_only_its_subsystems_get_managers(tmp_path: Path, name: str) -> None:
    with opened(tiny_scene(tmp_path, robots=2), robot=name) as session:
        assert sorted(session.managers) == ["arm_2", "base_2"]

        report = session.run(["In(ball_1, slot_1)"])

    assert report.reached
    assert {v for s in report.steps for k, v in s.arguments.items() if k == "Robot"} == {"robot_2"}


def test_an_unknown_robot_is_refused_before_anything_is_started(tmp_path: Path) -> None:
    with pytest.raises(UnknownName, match="unknown robot 'robbie'"):
        opened(tiny_scene(tmp_path), robot="robbie")


def test_a_plug_in_that_failed_to_load_does_not_affect_the_session(tmp_path: Path) -> None:
    scene = str(tiny_scene(tmp_path))

    with Session(scene, Options(fake=True), catalogue=catalogue(FAULT)) as session:
        assert session.catalogue.faults == (FAULT,)
        assert session.run(["In(ball_1, slot_1)"]).reached


def test_listeners_receive_every_plan(tmp_path: Path) -> None:
    heard: list[object] = []
    with opened(tiny_scene(tmp_path)) as session:
        session.on_plan(heard.append)
        session.run(["At(robot_1, box_a)"])

    assert len(heard) == 1


def test_the_next_goal_of_a_session_starts_without_state_of_the_previous_one(tmp_path: Path) -> None:
    with opened(tiny_scene(tmp_path)) as session:
        first = session.run(["In(ball_1, slot_1)"])
        second = session.run(["In(red_ball_1, slot_2)", "In(ball_1, slot_1)"])

    assert [s.skill for s in first.steps] == [s.skill for s in second.steps] == ["drive", "pick", "place"]
    assert [(c.tries, c.simulated == 0.0) for c in second.conditions] == [(1, False), (0, True)]
    assert second.simulated == pytest.approx(first.simulated, abs=0.02)


def test_a_session_continues_after_a_refused_goal(tmp_path: Path) -> None:
    with opened(tiny_scene(tmp_path)) as session:
        with pytest.raises(UsageError, match="In takes 2 arguments"):
            session.run(["In(ball_1)"])

        assert session.run(["In(ball_1, slot_1)"]).reached


def test_a_stop_does_not_affect_the_next_run(tmp_path: Path) -> None:
    with opened(tiny_scene(tmp_path)) as session:
        session.stop()

        assert session.run(["In(ball_1, slot_1)"]).stopped
        assert session.run(["In(ball_1, slot_1)"]).reached
