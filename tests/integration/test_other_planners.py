"""Every domain is standard PDDL: planners and readers of others take it as it is.

Fast Downward and Kairos solve each, unified-planning reads each, and pyperplan solves those that ask for nothing but
``:strips :typing``.
"""

from __future__ import annotations

import random
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import pytest
from support.planning import tiny_pddl
from unified_planning.environment import Environment
from unified_planning.io import PDDLReader

from skiros_py.planning.domain.pddl import PddlTexts
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.planners.planner import Solved
from skiros_py.skills.conditions import (
    AllOf,
    AnyOf,
    Condition,
    ConditionType,
    Exists,
    Not,
    Nothing,
    Pattern,
    Related,
    Role,
    any_of,
)
from skiros_py.skills.parameters import Param
from skiros_py.skills.skill import SkillDescription
from skiros_py.station.session import Options, Session
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import AT_LOCATION, CARRIES, DRIVE, EMPTY_HANDED, FREE, HOLDING, IN_CONTAINER, PICK, PLACE

_STRIPS = (":strips", ":typing")
_LONGEST = 60.0
"""Time that a planner of others gets [s]; each needs a fraction of a second."""
_BENCH = "scene:bench_1 a tiny:Bench ; sk:on scene:floor . scene:ball_5 a tiny:Ball ; sk:in scene:bench_1 ."
_UGLY = (
    "scene:Ball a tiny:Ball ; sk:in scene:box_a . scene:BALL a tiny:Ball ; sk:in scene:box_a .",
    "scene:object a tiny:Ball ; sk:in scene:box_a . scene:number a tiny:Slot ; sk:on scene:floor .",
    "scene:total_cost a tiny:Ball ; sk:in scene:box_a . scene:NOT a tiny:Slot ; sk:on scene:floor .",
)
_OTHER_AT = Exists("other", "sk:Robot", Related("sk:at", "other", "location"))
_ALONE = ConditionType(
    "Alone", (Role("robot", "sk:Robot"), Role("location", "sk:Location")), Not(_OTHER_AT), "Nobody stands there."
)
_ENTER = replace(DRIVE, pre=(*DRIVE.pre, _ALONE("Robot", "Location")))
_LEAVE = replace(DRIVE, name="leave", pre=(*DRIVE.pre, ~AT_LOCATION("Robot", "Location")))
_THROW = replace(PLACE, name="throw", pre=tuple(c for c in PLACE.pre if c.type is not FREE))
_LOAD = SkillDescription(
    "load",
    "Loads a ball.",
    "Robot",
    "Ball",
    (Param("Robot", "sk:Robot", "Who."), Param("Ball", "tiny:Ball", "What."), Param("Box", "tiny:Box", "Where.")),
    (AT_LOCATION("Robot", "Box"),),
    (),
    (CARRIES("Robot", "Ball"),),
)
_EITHER_BOX = replace(PICK, pre=(*PICK.pre, any_of(~EMPTY_HANDED("Gripper"), IN_CONTAINER("Ball", "Box"))))


@dataclass(frozen=True)
class Task:
    """A task of the tiny domain."""

    goal: tuple[Condition, ...]
    facts: tuple[str, ...] = ()
    skills: tuple[SkillDescription, ...] = (DRIVE, PICK, PLACE)
    robots: int = 1

    def texts(self) -> PddlTexts:
        """Returns it as PDDL."""
        return tiny_pddl(tiny_world(*self.facts, robots=self.robots), *self.goal, skills=self.skills)


def said(pattern: Pattern, **roles: str) -> Condition:
    """Returns a condition over elements, each under its own name."""
    return ConditionType("Said", tuple(Role(n, c) for n, c in roles.items()), pattern, "-")(*roles)


_SOMEHOW_THERE = Related("sk:placement", "ball_1", "slot_2")
_EMPTY = Nothing("sk:in", "box_a")
_STORED = Exists("slot", "tiny:Slot", Related("sk:in", "ball", "slot"))
TASKS = {
    "one element": Task((IN_CONTAINER("ball_1", "slot_1"),)),
    "any of a class": Task((IN_CONTAINER("tiny:Ball", "slot_1"), HOLDING("gripper_1", "ball_1"))),
    "two robots": Task((IN_CONTAINER("ball_1", "slot_1"), IN_CONTAINER("red_ball_1", "slot_2")), robots=2),
    "second parent": Task((IN_CONTAINER("ball_5", "slot_1"),), (_BENCH,)),
    "ids that PDDL cannot have": Task((IN_CONTAINER("BALL", "number"), IN_CONTAINER("total_cost", "NOT")), _UGLY),
    "not somewhere": Task((~IN_CONTAINER("ball_1", "box_a"), ~AT_LOCATION("robot_1", "box_a"))),
    "none of a class": Task((~IN_CONTAINER("tiny:Ball", "box_a"),)),
    "nothing there": Task((said(_EMPTY, box_a="tiny:Box"),)),
    "general relation": Task((said(_SOMEHOW_THERE, ball_1="tiny:Ball", slot_2="tiny:Slot"),)),
    "for all": Task((said(Not(Exists("ball", "tiny:Ball", Not(_STORED)))),)),
    "nested": Task(
        (
            said(
                AnyOf((AllOf((_EMPTY, Nothing("sk:at", "box_a"))), Exists("ball", "tiny:RedBall", _STORED))),
                box_a="tiny:Box",
            ),
        )
    ),
    "already so": Task((~IN_CONTAINER("ball_1", "box_b"),)),
    "negated precondition": Task((AT_LOCATION("robot_1", "box_a"),), skills=(_LEAVE,)),
    "variants": Task((IN_CONTAINER("ball_1", "slot_1"),), skills=(DRIVE, _EITHER_BOX, PLACE)),
    "place at the subject's end": Task(
        (CARRIES("robot_1", "ball_1"), ~IN_CONTAINER("ball_1", "box_a")), skills=(DRIVE, _LOAD), robots=2
    ),
    "nobody else there": Task((AT_LOCATION("robot_1", "box_a"),), skills=(_ENTER,), robots=2),
    "nobody keeps track": Task((IN_CONTAINER("ball_1", "slot_1"),), skills=(DRIVE, PICK, PLACE, _THROW)),
}
QUANTIFIED = {"nobody else there", "nobody keeps track"}


def random_task(seed: int) -> Task:
    """Draws a world and a goal that can be reached in it."""
    draw = random.Random(seed)
    balls = {f"b{i}": draw.choice(["box_a", "box_b"]) for i in range(draw.randint(1, 4))}
    kinds = {ball: draw.choice(["Ball", "RedBall"]) for ball in balls}
    facts = [f"scene:{ball} a tiny:{kinds[ball]} ; sk:in scene:{box} ." for ball, box in balls.items()]
    facts += [f"scene:s{i} a tiny:Slot ; sk:on scene:floor ." for i in range(len(balls))]
    goal = [IN_CONTAINER(ball, f"s{i}") for i, ball in enumerate(balls) if draw.random() < 0.6]
    goal += [~IN_CONTAINER(ball, box) for ball, box in balls.items() if draw.random() < 0.3]
    goal += [AT_LOCATION("robot_1", draw.choice(["box_a", "box_b"]))]
    return Task(tuple(goal), tuple(facts), robots=draw.randint(1, 2))


TASKS |= {f"random {seed}": random_task(seed) for seed in range(6)}
SCENES = ("kitting", "kitting_carried")


@cache
def texts_of(name: str) -> PddlTexts:
    if name not in SCENES:
        return TASKS[name].texts()
    with Session(name, Options(fake=True)) as session:
        texts = session.plan().texts
    assert texts is not None
    return texts


@pytest.fixture(params=[*TASKS, *SCENES])
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def texts(name: str) -> PddlTexts:
    return texts_of(name)


@pytest.fixture
def files(texts: PddlTexts, tmp_path: Path) -> tuple[str, str]:
    domain, problem = tmp_path / "domain.pddl", tmp_path / "problem.pddl"
    domain.write_text(texts.domain, encoding="utf-8")
    problem.write_text(texts.problem, encoding="utf-8")
    return str(domain), str(problem)


@pytest.fixture(scope="module")
def fast_downward() -> Iterator[FastDownward]:
    planner = FastDownward()
    yield planner
    planner.close()


def run(program: str, *arguments: str) -> str:
    """Runs a planner of others to its end and returns what it says."""
    command = [str(Path(sys.executable).parent / program), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=_LONGEST, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def test_fast_downward_solves_the_exported_problem(texts: PddlTexts, fast_downward: FastDownward) -> None:
    answer = fast_downward.solve(texts.domain, texts.problem).result()

    assert isinstance(answer, Solved)


@pytest.mark.filterwarnings("ignore:'parseString' deprecated")  # of its own parser, where it reads quantifiers
def test_unified_planning_reads_the_exported_problem(texts: PddlTexts, files: tuple[str, str]) -> None:
    problem = PDDLReader(Environment()).parse_problem(*files)

    assert {action.name for action in problem.actions} == set(texts.actions)


def test_kairos_solves_the_exported_problem(texts: PddlTexts, files: tuple[str, str]) -> None:
    told = run("kairos", "solve", *files, "--no-anytime", "--threads", "1")

    steps = re.findall(r"^\((\S+).*\)$", told, flags=re.MULTILINE)
    assert set(steps) <= set(texts.actions)


@pytest.mark.parametrize("name", [n for n in (*TASKS, *SCENES) if n not in QUANTIFIED])  # of those it knows nothing
def test_pyperplan_solves_exported_problems_that_need_only_strips(files: tuple[str, str]) -> None:
    assert "Plan length" in run("pyperplan", "-H", "hff", "-s", "gbf", *files)


def test_problems_whose_negations_compile_away_require_only_typed_strips(name: str, texts: PddlTexts) -> None:
    assert (texts.requirements == _STRIPS) == (name not in QUANTIFIED)


def test_the_required_features_are_those_declared_in_the_domain(texts: PddlTexts) -> None:
    assert re.findall(r"\(:requirements ([^)]*)\)", texts.domain) == [" ".join(texts.requirements)]


def test_only_used_requirements_are_declared(texts: PddlTexts) -> None:
    assert ("(exists (" in texts.domain) == (":existential-preconditions" in texts.requirements)
    assert ("(not (exists" in texts.domain) == (":disjunctive-preconditions" in texts.requirements)
