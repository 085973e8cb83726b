"""Every kind of pattern there is can be planned with, or is refused by name: none is dropped."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import count

import pytest
from support.planning import tiny_task

import skiros_py.skills.conditions as conditions
from skiros_py.errors import PlanningError, UsageError
from skiros_py.planning.domain.actions import actions_of
from skiros_py.planning.domain.literals import expand
from skiros_py.skills.conditions import (
    AllOf,
    AnyOf,
    ClassRelated,
    Compare,
    Computed,
    ConditionType,
    Decrease,
    Exists,
    Expression,
    Has,
    Increase,
    IsA,
    Not,
    Nothing,
    Pattern,
    Related,
    Role,
    Verdict,
)
from skiros_py.skills.parameters import Param
from skiros_py.testing import tiny_ontology, tiny_world
from skiros_py.testing.tiny import PICK

_IN = Related("sk:in", "ball", "box")
EXAMPLES: dict[type, Pattern] = {
    AllOf: AllOf((_IN, Has("tiny:scanned", "ball"))),
    AnyOf: AnyOf((_IN, Has("tiny:scanned", "ball"))),
    ClassRelated: ClassRelated("tiny:madeFor", "ball", "box"),
    Compare: Compare("tiny:scanned", "=", "ball", True),
    Decrease: Decrease("tiny:charge", "ball", 1.0),
    Increase: Increase("tiny:charge", "ball", 1.0),
    Computed: Computed("tiny:fitsIn", "ball", "box", lambda *_: Verdict(True, "")),
    Exists: Exists("other", "tiny:Ball", Related("sk:in", "other", "box")),
    Expression: Expression("ball.still"),
    Has: Has("tiny:scanned", "ball"),
    IsA: IsA("ball", "tiny:RedBall"),
    Not: Not(_IN),
    Nothing: Nothing("sk:in", "box"),
    Related: _IN,
}
REFUSED = {
    Expression: r"'\w+.still' can only be sensed",
    Increase: "Increase says what a skill does to a number; ask for the number",
    Decrease: "Decrease says what a skill does to a number; ask for the number",
}
KINDS = [kind for kind in vars(conditions).values() if isinstance(kind, type) and hasattr(kind, "rename")]
_kinds = pytest.mark.parametrize("kind", sorted(set(KINDS) - {Pattern}, key=lambda k: k.__name__))


def test_there_is_an_example_of_every_kind_of_pattern() -> None:
    assert set(EXAMPLES) == set(KINDS) - {Pattern}


@_kinds
@pytest.mark.parametrize("negated", [False, True])
def test_each_kind_of_pattern_is_a_precondition_or_refused_by_name(kind: type, negated: bool) -> None:
    pattern = Not(EXAMPLES[kind]) if negated else EXAMPLES[kind]
    if kind in REFUSED:
        with pytest.raises(PlanningError, match=f"here: {REFUSED[kind]}"):
            expand(pattern, "here", tiny_ontology(), count(1))
        return

    ways = expand(pattern, "here", tiny_ontology(), count(1))

    assert ways
    assert all(way.atoms or way.none for way in ways)


@_kinds
@pytest.mark.parametrize("negated", [False, True])
def test_each_kind_of_pattern_is_part_of_an_action_or_refused_with_its_skill(kind: type, negated: bool) -> None:
    word = ConditionType("Word", (Role("ball", "tiny:Ball"), Role("box", "tiny:Box")), EXAMPLES[kind], "-")
    condition = ~word("Ball", "Box") if negated else word("Ball", "Box")
    skill = replace(PICK, pre=(*PICK.pre, condition))
    if kind in REFUSED:
        with pytest.raises(PlanningError, match=rf"skill 'pick', precondition .*: {REFUSED[kind]}"):
            actions_of(skill, tiny_ontology())
        return
    plain = actions_of(PICK, tiny_ontology())[0]
    holds_anyway = (not negated and kind in (Related, AnyOf)) or (negated and kind is Not)

    for action in actions_of(skill, tiny_ontology()):
        differs = set(action.atoms) != set(plain.atoms) or action.parameters != plain.parameters
        assert differs or holds_anyway, "pick needs In(Ball, Box) already"


@_kinds
@pytest.mark.parametrize("negated", [False, True])
def test_each_kind_of_pattern_is_a_goal_or_refused_by_name(kind: type, negated: bool) -> None:
    word = ConditionType("Word", (Role("ball", "tiny:Ball"), Role("box", "sk:Container")), EXAMPLES[kind], "-")
    goal = ~word("ball_1", "box_b") if negated else word("ball_1", "box_b")
    if kind in REFUSED:
        with pytest.raises(UsageError, match=rf"goal '(not )?Word\(ball_1, box_b\)': {REFUSED[kind]}"):
            tiny_task(tiny_world(), goal)
        return

    task = tiny_task(tiny_world(), goal)

    assert task.problem.goal or goal.evaluate(tiny_world()), "what is no goal of the task holds, and goes on to hold"


@dataclass(frozen=True)
class _Homemade:
    """A kind of pattern that planning has never heard of."""

    def evaluate(self, view: object, binding: object) -> Verdict:
        return Verdict(True, "")

    def rename(self, names: object) -> _Homemade:
        return self


@pytest.mark.parametrize("pattern", [_Homemade(), Not(_Homemade()), AllOf((_IN, _Homemade())), AnyOf((_Homemade(),))])
def test_an_unknown_kind_of_pattern_is_refused_by_name(pattern: Pattern) -> None:
    with pytest.raises(PlanningError, match="here: a pattern of kind _Homemade cannot be planned with"):
        expand(pattern, "here", tiny_ontology(), count(1))


def test_an_unconstrained_parameter_stays_a_parameter() -> None:
    extra = Param("Extra", "tiny:Ball", "-")

    assert "?Extra" in actions_of(replace(PICK, params=(*PICK.params, extra)), tiny_ontology())[0].types
