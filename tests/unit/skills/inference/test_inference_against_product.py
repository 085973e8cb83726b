"""Whatever the search does to be quick, it answers what trying everything would."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from itertools import product

from hypothesis import example, given, settings
from hypothesis import strategies as st

from skiros_py.skills.conditions import (
    AllOf,
    AnyOf,
    Computed,
    Condition,
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
from skiros_py.skills.inference.inferring import Inferred, Missing, infer
from skiros_py.skills.parameters import Param
from skiros_py.skills.references import variables
from skiros_py.skills.skill import SkillDescription
from skiros_py.testing import tiny_world
from skiros_py.world.overlay import Overlay
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import AT, IN, MASS
from skiros_py.world.world import World

CLASSES = {"Robot": "sk:Robot", "Box": "tiny:Box", "Ball": "tiny:Ball", "Other": "tiny:Ball"}


def _alike(view: WorldView, one: str, other: str) -> Verdict:
    return Verdict(one[-1] == other[-1], f"{one} and {other}")


def leaves(keys: Sequence[str]) -> st.SearchStrategy[Pattern]:
    key = st.sampled_from(keys)
    return st.one_of(
        st.builds(Related, st.sampled_from([IN, AT, "tiny:knows", "sk:placement"]), key, key),
        st.builds(Nothing, st.sampled_from([IN, AT]), key),
        st.builds(Has, st.just(MASS), key),
        st.builds(Computed, st.just("sk:near"), key, key),
        st.builds(Computed, st.just("sk:near"), key, key, st.just(_alike)),
    )


def patterns(keys: Sequence[str]) -> st.SearchStrategy[Pattern]:
    def composed(inner: st.SearchStrategy[Pattern]) -> st.SearchStrategy[Pattern]:
        several = st.lists(inner, min_size=1, max_size=3).map(tuple)
        exists = st.sampled_from(["tiny:Box", "tiny:Ball"]).flatmap(
            lambda class_: patterns_without_quantifier([*keys, "x"]).map(lambda p: Exists("x", class_, p))
        )
        return st.one_of(st.builds(Not, inner), st.builds(AllOf, several), st.builds(AnyOf, several), exists)

    return st.recursive(leaves(keys), composed, max_leaves=4)


def patterns_without_quantifier(keys: Sequence[str]) -> st.SearchStrategy[Pattern]:
    several = st.lists(leaves(keys), min_size=1, max_size=3).map(tuple)
    return st.one_of(leaves(keys), st.builds(AllOf, several), st.builds(AnyOf, several))


def condition(pattern: Pattern) -> Condition:
    roles = tuple(Role(key, CLASSES[key]) for key in variables(pattern))
    return ConditionType("Word", roles, pattern, "A word.")(*(role.name for role in roles))


@st.composite
def skills(draw: st.DrawFn) -> SkillDescription:
    keys = list(CLASSES)
    params = []
    for key, class_ in CLASSES.items():
        about_it = st.one_of(leaves(["it"]), leaves(["it", *keys])).filter(lambda p: "it" in variables(p))
        prefer = tuple(draw(st.lists(about_it, max_size=2)))
        cost = draw(st.sampled_from([None, None, MASS, lambda view, name: float(ord(name[-1]))]))
        params.append(Param(key, class_, "It.", prefer=prefer, cost=cost, unique=draw(st.integers(0, 9)) == 0))
    pre = tuple(condition(p) for p in draw(st.lists(patterns(keys), max_size=4)) if variables(p))
    return skill(params, pre)


def skill(params: Sequence[Param], pre: Sequence[Condition]) -> SkillDescription:
    post = (condition(Has(MASS, "Box")),)
    return SkillDescription("do", "Does.", "Robot", "Box", tuple(params), tuple(pre), (), post)


HEAVY_BOX = Exists("x", "tiny:Box", Has(MASS, "x"))
"""Names none of the parameters; no box of :func:`base` has a mass."""

NO_HEAVY_BOX = skill(
    [Param(key, class_, "It.") for key, class_ in CLASSES.items()],
    [condition(AllOf((Nothing(IN, "Robot"), HEAVY_BOX)))],
)


@cache
def base() -> World:
    balls = (
        f'scene:ball_{n} a tiny:Ball ; sk:in scene:box_a ; sk:pose "{n} 0 0 0 0 0"^^sk:poseLiteral .' for n in (2, 3)
    )
    return tiny_world(*balls, robots=2)


@st.composite
def worlds(draw: st.DrawFn) -> WorldView:
    world = Overlay(base())
    for ball in world.instances("tiny:Ball"):
        world.place(ball, IN, draw(st.sampled_from(["box_a", "box_b", "slot_1"])))
        world.set_value(ball, MASS, draw(st.sampled_from([None, 1.0, 2.0])))
    for box in draw(st.sets(st.sampled_from(["box_a", "box_b"]))):
        world.set_relation("robot_1", "tiny:knows", box)
    world.place("robot_1", AT, draw(st.sampled_from(["box_a", "floor"])))
    return world


def naive(skill: SkillDescription, known: Mapping[str, str], view: WorldView) -> list[dict[str, str]]:
    open_ = [param for param in skill.params if param.key not in known]
    needs = [need for need in skill.needs if not set(need.arguments) <= set(known)]
    found = []
    for values in product(*(view.instances(param.element_class) for param in open_)):
        binding = {**known, **{param.key: value for param, value in zip(open_, values, strict=True)}}
        if all(need.evaluate(view, binding) for need in needs):
            found.append(binding)
    return found


def rank(skill: SkillDescription, known: Mapping[str, str], view: WorldView, binding: dict[str, str]) -> object:
    open_ = [param for param in skill.params if param.key not in known]
    preferences, costs = [], []
    for param in open_:
        held = [bool(p.evaluate(view, {**binding, "it": binding[param.key]})) for p in param.preferred]
        preferences.append(held.index(True) if True in held else len(held))
        costs.append(cost_of(param, binding[param.key], view))
    return preferences, costs, [binding[param.key] for param in open_]


def cost_of(param: Param, name: str, view: WorldView) -> float:
    if param.cost is None:
        return 0.0
    value = view.value(name, param.cost) if isinstance(param.cost, str) else param.cost(view, name)
    return float("inf") if value is None else float(value)  # type: ignore[arg-type]


@settings(max_examples=150, deadline=None)
@given(world=worlds(), skill=skills(), agent=st.sampled_from([None, "robot_1"]))
def test_the_best_of_all_combinations_is_found(world: WorldView, skill: SkillDescription, agent: str | None) -> None:
    known = {"Robot": agent} if agent else {}
    expected = naive(skill, known, world)

    answer = infer(skill, {}, world, agent)

    if not expected:
        return
    unclear = tuple(p.key for p in skill.params if p.unique and len({binding[p.key] for binding in expected}) > 1)
    if unclear:
        assert isinstance(answer, Missing)
        assert answer.keys == unclear
    else:
        assert isinstance(answer, Inferred)
        assert answer.values == min(expected, key=lambda binding: rank(skill, known, world, binding))


@settings(max_examples=100, deadline=None)
@given(world=worlds(), skill=skills())
@example(world=base(), skill=NO_HEAVY_BOX)
def test_without_a_solution_no_answer_fulfils_all_conditions(world: WorldView, skill: SkillDescription) -> None:
    expected = naive(skill, {}, world)

    answer = infer(skill, {}, world)

    if not expected and isinstance(answer, Inferred):
        assert not all(need.evaluate(world, answer.values) for need in skill.needs)
        assert any("does not hold" in reason for reason in answer.reasons.values())
