from __future__ import annotations

from dataclasses import replace

import kairos
import pytest
from support.planning import tiny_task
from unified_planning.io import PDDLReader

from skiros_py.planning.domain.pddl import PddlTexts
from skiros_py.planning.domain.temporal import write_temporal
from skiros_py.planning.experience import timed
from skiros_py.planning.plan import Plan
from skiros_py.planning.plan_validation import validate
from skiros_py.planning.planners.kairos import Kairos
from skiros_py.planning.planners.planner import Solved, Unsolvable
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.robots.allocation import deal
from skiros_py.planning.robots.ordering import order
from skiros_py.skills.conditions import Condition
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import DRIVE, HOLDING, IN_CONTAINER, PICK, PLACE
from skiros_py.world.world import World

SECONDS = {"drive": 5.0, "pick": 3.0, "place": 2.0}
SKILLS = tuple(replace(skill, duration=SECONDS[skill.name]) for skill in (DRIVE, PICK, PLACE))
BOTH = IN_CONTAINER("ball_1", "slot_1"), IN_CONTAINER("red_ball_1", "slot_2")


def temporal(world: World, *goal: Condition) -> tuple[PlanningTask, PddlTexts]:
    task = deal(timed(tiny_task(world, *goal, skills=SKILLS)))
    return task, write_temporal(task, name="tiny in time")


def solved(texts: PddlTexts) -> Solved:
    answer = Kairos().solve(texts.domain, texts.problem).result()
    assert isinstance(answer, Solved)
    return answer


def test_a_temporal_planner_lets_two_robots_work_side_by_side() -> None:
    world = tiny_world(robots=2)
    task, texts = temporal(world, *BOTH)
    answer = solved(texts)
    plan = validate(task, texts, answer)

    assert isinstance(plan, Plan)
    assert max(map(sum, zip(answer.starts, answer.durations, strict=True))) == pytest.approx(10.0, abs=0.1)
    ordered = order(task, plan)
    assert max(start + SECONDS[s.skill] for start, s in zip(ordered.starts, ordered.steps, strict=True)) == 10.0


def test_the_answer_of_a_temporal_planner_is_replayed_like_any_other() -> None:
    world = tiny_world()
    task, texts = temporal(world, *BOTH)
    answer = solved(texts)
    backwards = replace(answer, steps=tuple(reversed(answer.steps)))

    assert isinstance(validate(task, texts, answer), Plan)
    assert not isinstance(validate(task, texts, backwards), Plan)


def test_a_base_does_not_leave_while_its_arm_works_there() -> None:
    world = tiny_world()
    _, texts = temporal(world, *BOTH)
    answer = solved(texts)
    each = [
        (s[0], at, at + seconds) for s, at, seconds in zip(answer.steps, answer.starts, answer.durations, strict=True)
    ]
    drives = [(start, end) for name, start, end in each if name == "drive"]
    picks = [(start, end) for name, start, end in each if name == "pick"]

    assert not any(start < b and a < end for start, end in drives for a, b in picks)


def test_the_requirements_list_exactly_the_used_features() -> None:
    _, texts = temporal(tiny_world(), *BOTH)

    assert texts.requirements == (":strips", ":typing", ":durative-actions")
    assert "(:requirements :strips :typing :durative-actions)" in texts.domain


def test_bookkeeping_actions_have_no_duration() -> None:
    _, texts = temporal(tiny_world(), HOLDING("gripper_1", "tiny:RedBall"))

    assert "(:action finish" in texts.domain
    assert "(:durative-action pick" in texts.domain
    assert isinstance(Kairos().solve(texts.domain, texts.problem).result(), Solved)


def test_a_skill_of_unknown_duration_has_the_default_duration() -> None:
    world = tiny_world()
    texts = write_temporal(tiny_task(world, *BOTH), name="tiny")

    assert texts.domain.count(":duration (= ?duration 10.000)") == 3


def test_the_absence_of_a_temporal_plan_is_reported() -> None:
    world = tiny_world("scene:giant_1 a tiny:Giant ; sk:in scene:box_a .")
    _, texts = temporal(world, IN_CONTAINER("giant_1", "slot_1"))

    assert isinstance(Kairos().solve(texts.domain, texts.problem).result(), Unsolvable)


def test_other_pddl_parsers_accept_the_temporal_texts_and_the_plan() -> None:
    world = tiny_world(robots=2)
    _, texts = temporal(world, *BOTH)
    read = PDDLReader().parse_problem_string(texts.domain, texts.problem)
    domain = kairos.parse_domain(texts.domain)
    problem = kairos.parse_problem(texts.problem, domain)
    result = kairos.Planner().solve(problem, anytime=False)

    assert read.kind.has_continuous_time()
    assert {action.name for action in read.actions} == {"drive", "pick", "place"}
    assert result.status == kairos.Status.SOLVED
    assert kairos.validate(problem, result.plan).valid
