from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import pytest

from skiros_py.behaviours import AssertEffects, Behaviour, Do, Fallback, P, Retry, Sequence
from skiros_py.skills.conditions import (
    AllOf,
    AnyOf,
    Computed,
    ConditionType,
    Exists,
    Has,
    Not,
    Nothing,
    Pattern,
    Related,
    Role,
    Verdict,
)
from skiros_py.skills.lint.checking import problems_of
from skiros_py.skills.outcome import Outcome, Success
from skiros_py.skills.parameters import Kind, Param, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill
from skiros_py.testing import SKILLS, tiny_ontology
from skiros_py.testing.tiny import DRIVE, pretend
from skiros_py.world.reasoners.registry import Reasoners
from skiros_py.world.reasoners.spatial import SpatialReasoner


class Look(Primitive[Any]):
    name: ClassVar[str] = "look"

    @dataclass(frozen=True, slots=True)
    class Params:
        at: str = param("sk:Location", "Where to look.")
        times: int = param("integer", "How often.", kind=Kind.OFFLINE, default=1)

    def execute(self) -> Execution[Outcome]:
        yield
        return Success()


PRIMITIVES: Mapping[str, type[Primitive[Any]]] = {"look": Look}


def problems(skill: Skill) -> tuple[str, ...]:
    return problems_of(skill, tiny_ontology(), PRIMITIVES)


def problems_of_body(body: Behaviour) -> tuple[str, ...]:
    return problems(pretend(DRIVE, body))


def problems_of_pattern(pattern: Pattern, field: str = "pre") -> tuple[str, ...]:
    odd = ConditionType("Odd", (Role("a", "sk:Robot"), Role("b", "sk:Location")), pattern, "-")
    return problems(pretend(replace(DRIVE, **{field: (odd("Robot", "Location"),)})))


@pytest.mark.parametrize("skill", SKILLS, ids=lambda s: s.description.name)
def test_a_good_skill_has_no_problems(skill: Skill) -> None:
    assert problems(skill) == ()


def test_a_good_call_has_no_problems() -> None:
    assert problems_of_body(Do.of("look", at=P("Location"), times=3)) == ()


def test_a_parameter_of_an_undeclared_class_is_named() -> None:
    drone = replace(DRIVE, params=(Param("Base", "uav:Drone", "Who."), *DRIVE.params[1:]))

    assert problems(pretend(drone)) == ("parameter Base: no ontology declares the class uav:Drone",)


def test_a_parameter_that_is_no_element_needs_no_class() -> None:
    assert problems(pretend(replace(DRIVE, params=(*DRIVE.params, Param("Speed", "number", "How fast."))))) == ()


BAD = Related("tiny:under", "a", "b")


@pytest.mark.parametrize(
    ("pattern", "problem"),
    [
        (BAD, "relation tiny:under"),
        (Nothing("tiny:under", "b"), "relation tiny:under"),
        (Computed("tiny:under", "a", "b", lambda *_: Verdict(True, "")), "relation tiny:under"),
        (Has("tiny:colour", "b"), "property tiny:colour"),
        (Exists("x", "tiny:Shelf", Related("sk:at", "a", "x")), "class tiny:Shelf"),
        (Exists("x", "tiny:Box", BAD), "relation tiny:under"),
        (Not(BAD), "relation tiny:under"),
        (AllOf((Related("sk:at", "a", "b"), BAD)), "relation tiny:under"),
        (AnyOf((BAD, Related("sk:at", "a", "b"))), "relation tiny:under"),
    ],
    ids=lambda value: type(value).__name__ if not isinstance(value, str) else "",
)
def test_an_undeclared_term_is_found_in_any_position(pattern: Pattern, problem: str) -> None:
    assert problems_of_pattern(pattern) == (f"condition Odd(Robot, Location): no ontology declares the {problem}",)


@pytest.mark.parametrize("wrap", [lambda p: p, Not, lambda p: AllOf((p,)), lambda p: Exists("x", "tiny:Box", p)])
def test_a_computed_relation_without_a_reasoner_is_found_in_any_position(wrap: Callable[[Pattern], Pattern]) -> None:
    (problem,) = problems_of_pattern(wrap(Computed("sk:near", "a", "b")))

    assert problem.endswith("no reasoner computes sk:near, and no function is given for it")


def test_a_relation_computed_by_a_reasoner_or_function_is_accepted() -> None:
    near = ConditionType("Near", (Role("a", "sk:Robot"), Role("b", "sk:Location")), Computed("sk:near", "a", "b"), "-")
    skill = pretend(replace(DRIVE, pre=(*DRIVE.pre, near("Robot", "Location"))))

    assert problems_of(skill, tiny_ontology(), {}, Reasoners((SpatialReasoner(),))) == ()
    assert problems_of_pattern(Computed("sk:near", "a", "b", lambda *_: Verdict(True, ""))) == ()


@pytest.mark.parametrize("field", ["pre", "hold", "post"])
def test_pre_hold_and_postconditions_are_all_read(field: str) -> None:
    assert len(problems_of_pattern(BAD, field)) == 1


def test_a_pattern_of_a_foreign_kind_is_named() -> None:
    class Maybe:
        def evaluate(self, view: object, binding: object) -> Verdict:
            return Verdict(True, "")

        def rename(self, names: Mapping[str, str]) -> Pattern:
            return self  # type: ignore[return-value]

    (problem,) = problems_of_pattern(Maybe())  # type: ignore[arg-type]

    assert "Maybe" in problem


@pytest.mark.parametrize(
    ("call", "problem"),
    [
        (Do.of("lok"), "there is no primitive or skill 'lok'; did you mean look?; there is look"),
        (Do.of("fly"), "there is no primitive or skill 'fly'; there is look"),
        (Do.of("look", at=P("Location"), to=P("Location")), "primitive 'look' has no parameter to"),
        (Do.of("look"), "primitive 'look' needs at"),
    ],
)
def test_a_call_of_a_missing_module_is_named(call: Do, problem: str) -> None:
    assert problems_of_body(call) == (problem,)


@pytest.mark.parametrize(
    "body",
    [
        Sequence.of(AssertEffects(), Do.of("lok")),
        Fallback.of(Do.of("lok"), AssertEffects()),
        Retry(Do.of("lok"), 2),
        Sequence.of(Retry(Fallback.of(Do.of("lok")), 2)),
    ],
)
def test_calls_are_found_anywhere_in_the_body(body: Behaviour) -> None:
    assert len(problems_of_body(body)) == 1


def test_pre_sensing_and_finish_are_read_too() -> None:
    skill = Skill(DRIVE, AssertEffects(), pre_sense=Do.of("lok"), finish=Do.of("luk"), driver="fake")

    assert [problem.partition(";")[0] for problem in problems(skill)] == [
        "there is no primitive or skill 'lok'",
        "there is no primitive or skill 'luk'",
    ]


def test_all_problems_are_reported_at_once() -> None:
    drone = replace(DRIVE, params=(Param("Base", "uav:Drone", "Who."), *DRIVE.params[1:]))

    assert len(problems(Skill(drone, Sequence.of(Do.of("lok"), Do.of("look", at="x", to=1))))) == 3


def test_missing_primitives_are_reported_if_there_are_none_at_all() -> None:
    assert problems_of(Skill(DRIVE, Do.of("look")), tiny_ontology(), {}) == (
        "there is no primitive or skill 'look'; there is none",
    )
