from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from support.planning import tiny_pddl
from unified_planning.environment import Environment
from unified_planning.io import PDDLReader

from skiros_py.planning.domain.pddl import PddlTexts
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.planners.planner import Solved
from skiros_py.skills.conditions import AllOf, Condition, ConditionType, Exists, Related, Role, any_of
from skiros_py.skills.parameters import Param
from skiros_py.skills.skill import SkillDescription
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import (
    AT_LOCATION,
    CARRIES,
    DRIVE,
    EMPTY_HANDED,
    HOLDING,
    IN_CONTAINER,
    PICK,
    PLACE,
    REACHABLE,
)

BENCH = "scene:bench_1 a tiny:Bench ; sk:on scene:floor . scene:ball_5 a tiny:Ball ; sk:in scene:bench_1 ."
UGLY = "scene:Ball a tiny:Ball ; sk:in scene:box_a . scene:BALL a tiny:Ball ; sk:in scene:box_a ."
KEYWORDS = "scene:object a tiny:Ball ; sk:in scene:box_a . scene:and a tiny:Slot ; sk:on scene:floor ."
_EITHER = replace(DRIVE, pre=(any_of(REACHABLE("Location"), AT_LOCATION("Robot", "Location")), *DRIVE.pre[:1]))
_GRIPPER = Param("Gripper", "sk:Gripper", "What it must not carry.")
_CAREFUL = replace(DRIVE, params=(*DRIVE.params, _GRIPPER), hold=(EMPTY_HANDED("Gripper"),))
_STORED = ConditionType(
    "Stored",
    (Role("ball", "tiny:Ball"), Role("where", "sk:Location")),
    Exists("box", "tiny:Box", AllOf((Related("sk:in", "ball", "box"), Related("sk:on", "box", "where")))),
    "The ball lies in some box that stands there.",
)
_LOAD = SkillDescription(
    "load",
    "Loads a ball.",
    "Robot",
    "Ball",
    (Param("Robot", "sk:Robot", "Who."), Param("Ball", "tiny:Ball", "What."), Param("Box", "tiny:Box", "Where.")),
    (IN_CONTAINER("Ball", "Box"), AT_LOCATION("Robot", "Box")),
    (),
    (CARRIES("Robot", "Ball"),),
)
_FETCH = replace(
    _LOAD,
    name="fetch",
    params=(*_LOAD.params, Param("Other", "tiny:Ball", "Another."), Param("Where", "sk:Location", "Where.")),
    pre=(_STORED("Ball", "Where"), _STORED("Other", "Where"), AT_LOCATION("Robot", "Box")),
)
_TO_PLACE = replace(
    DRIVE,
    name="Größer",
    target="2. Ort",
    params=(*DRIVE.params[:2], Param("2. Ort", "sk:Location", "Where to go.")),
    pre=(DRIVE.pre[0], REACHABLE("2. Ort")),
    post=(AT_LOCATION("Robot", "2. Ort"),),
)
_TWINS = SkillDescription(
    "send",
    "One robot sends another.",
    "Robot",
    "robot",
    (
        Param("Robot", "sk:Robot", "Who."),
        Param("robot", "sk:Robot", "Whom."),
        Param("Location", "sk:Location", "Where."),
    ),
    (),
    (),
    (AT_LOCATION("robot", "Location"),),
)
DOMAINS = [
    pytest.param((), (DRIVE, PICK, PLACE), (IN_CONTAINER("ball_1", "slot_1"),), id="one element"),
    pytest.param((), (DRIVE, PICK, PLACE), (IN_CONTAINER("tiny:Ball", "slot_1"),), id="any of a class"),
    pytest.param(
        (), (DRIVE, PICK, PLACE), (IN_CONTAINER("tiny:Ball", "slot_1"), HOLDING("gripper_1", "ball_1")), id="mixed"
    ),
    pytest.param((BENCH,), (DRIVE, PICK, PLACE), (IN_CONTAINER("ball_5", "slot_1"),), id="second parent"),
    pytest.param((UGLY,), (DRIVE, PICK, PLACE), (IN_CONTAINER("BALL", "slot_1"),), id="ids that differ in case"),
    pytest.param((KEYWORDS,), (DRIVE, PICK, PLACE), (IN_CONTAINER("object", "and"),), id="ids that are keywords"),
    pytest.param((), (_EITHER, PICK, PLACE), (IN_CONTAINER("ball_1", "slot_1"),), id="variants"),
    pytest.param((), (DRIVE, _LOAD), (CARRIES("robot_1", "red_ball_1"),), id="place at the subject's end"),
    pytest.param((), (_CAREFUL, PICK, PLACE), (IN_CONTAINER("ball_1", "slot_1"),), id="hold condition"),
    pytest.param((), (DRIVE, _FETCH), (CARRIES("robot_1", "ball_1"),), id="two existentials of one name"),
    pytest.param((), (_TO_PLACE, PICK, PLACE), (IN_CONTAINER("ball_1", "slot_1"),), id="letters PDDL lacks"),
    pytest.param((), (_TWINS,), (AT_LOCATION("robot_1", "box_a"),), id="parameters that differ in case"),
    pytest.param((), (DRIVE, PICK, PLACE), (~EMPTY_HANDED("gripper_1"),), id="something must be there"),
    pytest.param(
        (),
        (replace(DRIVE, name="ball_1"), replace(PICK, name="slot"), replace(PLACE, name="in")),
        (IN_CONTAINER("tiny:Ball", "slot_1"),),
        id="skills called like an object, a type, a predicate",
    ),
    pytest.param(
        (),
        (replace(_EITHER, name="go"), replace(DRIVE, name="go_1"), replace(PICK, name="finish"), PLACE),
        (IN_CONTAINER("tiny:Ball", "slot_1"),),
        id="skills called like variants and bookkeeping",
    ),
]


def texts_of(facts: tuple[str, ...], skills: tuple[SkillDescription, ...], goal: tuple[Condition, ...]) -> PddlTexts:
    return tiny_pddl(tiny_world(*facts), *goal, skills=skills)


@pytest.mark.parametrize(("facts", "skills", "goal"), DOMAINS)
def test_fast_downward_accepts_the_domain_and_solves_it(
    facts: tuple[str, ...], skills: tuple[SkillDescription, ...], goal: tuple[Condition, ...]
) -> None:
    texts = texts_of(facts, skills, goal)
    planner = FastDownward()

    answer = planner.solve(texts.domain, texts.problem).result()
    planner.close()

    assert isinstance(answer, Solved)
    assert all(name in texts.actions for name, *_ in answer.steps)


@pytest.mark.parametrize(("facts", "skills", "goal"), DOMAINS)
def test_unified_planning_reads_the_same_files(
    facts: tuple[str, ...], skills: tuple[SkillDescription, ...], goal: tuple[Condition, ...], tmp_path: Path
) -> None:
    texts = texts_of(facts, skills, goal)
    (tmp_path / "domain.pddl").write_text(texts.domain, encoding="utf-8")
    (tmp_path / "problem.pddl").write_text(texts.problem, encoding="utf-8")

    problem = PDDLReader(Environment()).parse_problem(str(tmp_path / "domain.pddl"), str(tmp_path / "problem.pddl"))

    assert {action.name for action in problem.actions} == set(texts.actions)


@pytest.mark.parametrize(("facts", "skills", "goal"), DOMAINS)
def test_equal_worlds_give_equal_texts(
    facts: tuple[str, ...], skills: tuple[SkillDescription, ...], goal: tuple[Condition, ...]
) -> None:
    one, other = texts_of(facts, skills, goal), texts_of(facts, skills, goal)

    assert (one.domain, one.problem) == (other.domain, other.problem)


@pytest.mark.parametrize(("facts", "skills", "goal"), DOMAINS)
def test_the_domain_requires_only_strips_and_typing(
    facts: tuple[str, ...], skills: tuple[SkillDescription, ...], goal: tuple[Condition, ...]
) -> None:
    domain = texts_of(facts, skills, goal).domain

    assert re.findall(r"\(:requirements ([^)]*)\)", domain) == [":strips :typing"]
    assert not re.search(r"\((or|forall|exists|when|imply|=|either)\b", domain)


@pytest.mark.parametrize(("facts", "skills", "goal"), DOMAINS)
def test_every_predicate_in_use_is_declared_once(
    facts: tuple[str, ...], skills: tuple[SkillDescription, ...], goal: tuple[Condition, ...]
) -> None:
    domain = texts_of(facts, skills, goal).domain
    declared = re.findall(r"\(([a-z][\w-]*)", domain.partition("(:predicates")[2].partition("(:action")[0])
    used = set(re.findall(r"\(([a-z][\w-]*)", domain.partition("(:action")[2])) - {"and", "not"}

    assert len(declared) == len(set(declared))
    assert used <= set(declared)


def test_a_precondition_is_never_negative() -> None:
    domain = texts_of((), (DRIVE, PICK, PLACE), (IN_CONTAINER("ball_1", "slot_1"),)).domain

    for precondition in re.findall(r":precondition(.*?):effect", domain, flags=re.DOTALL):
        assert "(not (" not in precondition


def test_elements_that_a_goal_of_a_class_names_are_constants() -> None:
    texts = texts_of((), (DRIVE, PICK, PLACE), (IN_CONTAINER("tiny:Ball", "slot_1"),))

    assert "(:constants\n    slot_1 - slot\n  )" in texts.domain
    assert "slot_1 - slot" not in texts.problem


def test_only_elements_that_some_parameter_accepts_are_in_the_problem() -> None:
    texts = texts_of((), (DRIVE,), (AT_LOCATION("robot_1", "box_a"),))

    assert "box_b - box" in texts.problem
    assert "ball_1" not in texts.problem
    assert "gripper_1" not in texts.problem


def test_capabilities_that_robots_lack_are_not_facts() -> None:
    texts = texts_of((), (DRIVE, PICK, PLACE), (IN_CONTAINER("ball_1", "slot_1"),))

    assert re.findall(r"\(can_\w+ \w+\)", texts.problem) == [
        "(can_drive base_1)",
        "(can_pick arm_1)",
        "(can_place arm_1)",
    ]


@pytest.mark.parametrize(("facts", "skills", "goal"), DOMAINS)
def test_objects_types_predicates_and_actions_never_share_a_name(
    facts: tuple[str, ...], skills: tuple[SkillDescription, ...], goal: tuple[Condition, ...]
) -> None:
    texts = texts_of(facts, skills, goal)
    head = texts.domain.partition("(:action")[0]
    typing = head.partition("(:types")[2].partition(")")[0]
    constants = head.partition("(:constants")[2].partition("(:predicates")[0]
    objects = texts.problem.partition("(:objects")[2].partition(")")[0]

    names = re.findall(r"^ +([\w-]+) - ", f"{typing}\n{constants}\n{objects}", flags=re.MULTILINE)
    names += re.findall(r"^ +\(([\w-]+)", head.partition("(:predicates")[2], flags=re.MULTILINE)
    names += re.findall(r"\(:action ([\w-]+)", texts.domain)

    assert len(names) == len(set(names))
    assert set(texts.actions) <= set(names)


def test_an_object_keeps_its_name_and_the_type_called_like_it_gets_another() -> None:
    texts = texts_of((), (DRIVE,), (AT_LOCATION("robot_1", "box_a"),))

    assert "    floor - floor-2\n" in texts.problem


def test_variants_are_numbered_after_their_skill() -> None:
    world = tiny_world()
    with world.transaction("test", "the robot stands somewhere") as tx:
        tx.place("robot_1", "sk:at", "box_a")

    texts = tiny_pddl(world, AT_LOCATION("robot_1", "box_b"), skills=(_EITHER,))

    assert re.findall(r"\(:action ([\w-]+)", texts.domain) == ["drive_1", "drive_2"]


def test_variables_of_two_existentials_are_distinguished_by_number() -> None:
    domain = texts_of((), (_FETCH,), (CARRIES("robot_1", "ball_1"),)).domain

    assert "(in ?ball ?box-2)" in domain
    assert "(in ?other ?box-3)" in domain
