"""The three forms of goals say the same, both ways."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.config import ontology_paths
from skiros_py.errors import GoalSyntaxError, UnknownName, UsageError
from skiros_py.skills.conditions import Condition, all_of, any_of, exists, for_all
from skiros_py.skills.conditions.compound import Junction, Quantified
from skiros_py.tasks.goals import goal_as_data, goal_as_text, goal_from_data, parse_goal
from skiros_py.testing import CONDITIONS, TINY_ONTOLOGY, tiny_scene, tiny_world
from skiros_py.testing.tiny import AT_LOCATION, EMPTY_HANDED, FREE, HOLDING, IN_CONTAINER
from skiros_py.world.ontology import Ontology
from skiros_py.world.scene.files import load_scene
from skiros_py.world.world import World

WORLD = tiny_world()


def parse(*texts: str) -> tuple[Condition, ...]:
    return parse_goal(texts, WORLD, CONDITIONS)


def from_data(data: object) -> tuple[Condition, ...]:
    return goal_from_data(data, WORLD, CONDITIONS)


words = st.one_of(
    st.builds(
        IN_CONTAINER,
        st.sampled_from(["ball_1", "tiny:Ball", "tiny:RedBall", "b1", "b2"]),
        st.sampled_from(["slot_1", "box_a", "s1", "s2"]),
    ),
    st.builds(FREE, st.sampled_from(["slot_1", "slot_2", "s1", "s2"])),
    st.builds(EMPTY_HANDED, st.just("gripper_1")),
)


def close(condition: Condition, kinds: list[Callable[..., Condition]]) -> Condition:
    """Binds the variables that are left."""
    for variable, kind in zip(("b1", "b2", "s1", "s2"), kinds, strict=True):
        if variable in condition.arguments:
            condition = kind(variable, "tiny:Ball" if variable.startswith("b") else "tiny:Slot", condition)
    return condition


def grown(inner: st.SearchStrategy[Condition]) -> st.SearchStrategy[Condition]:
    several = st.lists(inner, min_size=2, max_size=3)
    return st.one_of(
        inner.map(lambda c: ~c),
        st.builds(lambda parts: all_of(*parts), several),
        st.builds(lambda parts: any_of(*parts), several),
    )


conditions = st.builds(
    close,
    st.recursive(words, grown, max_leaves=8),
    st.lists(st.sampled_from([for_all, exists]), min_size=4, max_size=4),
)
goals = st.lists(conditions, min_size=1, max_size=3).map(
    lambda found: tuple(dict.fromkeys(part for condition in found for part in split(condition)))
)


def split(condition: Condition) -> tuple[Condition, ...]:
    """What "and" joins are several conditions of a goal."""
    together = isinstance(condition, Junction) and condition.word == "and" and not condition.negated
    return condition.parts if isinstance(condition, Junction) and together else (condition,)


def as_pddl(condition: Condition) -> str:
    """Writes a condition as another program might."""
    if condition.negated:
        return f"(not {as_pddl(~condition)})"
    match condition:
        case Junction(word=word, parts=parts):
            return f"({word} {' '.join(map(as_pddl, parts))})"
        case Quantified(quantifier=quantifier, variable=variable, class_=class_, part=part):
            word = quantifier.replace(" ", "")
            inner = as_pddl(part)
            return f"({word} (?{variable} - {spelt(class_)}) {inner})"
        case _:
            arguments = [f"?{a}" if a[:2] in ("b1", "b2", "s1", "s2") else spelt(a) for a in condition.arguments]
            names = {"In": "in", "Free": "free", "EmptyHanded": "empty_handed"}
            return f"({names[condition.type.name]} {' '.join(arguments)})"


def spelt(name: str) -> str:
    return {"tiny:Ball": "ball", "tiny:RedBall": "red_ball", "tiny:Slot": "SLOT"}.get(name, name)


@settings(deadline=None)
@given(goals)
def test_a_goal_is_read_from_its_text_as_the_same(goal: tuple[Condition, ...]) -> None:
    assert parse(goal_as_text(goal)) == goal
    assert parse(*map(str, goal)) == goal


@settings(deadline=None)
@given(goals)
def test_a_goal_is_read_from_its_data_as_the_same(goal: tuple[Condition, ...]) -> None:
    assert from_data(json.loads(json.dumps(goal_as_data(goal)))) == goal


@settings(deadline=None)
@given(goals)
def test_a_goal_is_read_from_pddl_as_the_same(goal: tuple[Condition, ...]) -> None:
    assert parse(f"(and {' '.join(map(as_pddl, goal))})") == goal


@settings(deadline=None)
@given(st.text(alphabet='()?-; \n"andorexistfl:slotball_1', max_size=40))
def test_any_pddl_is_read_or_answered_with_a_usage_error(text: str) -> None:
    try:
        goal = parse("(" + text)
    except UsageError as error:
        answer = str(error)
    else:
        assert parse(goal_as_text(goal)) == goal
        answer = "read"
    assert answer


def test_pddl_may_span_lines_have_comments_and_declare_several_variables() -> None:
    text = """; every ball that is somewhere
    (FORALL (?ball-1 ?b - Ball ?s - tiny:Slot)
      (imply (and (In ?ball-1 ?s) (in ?b ?s))  ; both
             (not (free "slot 1"))))"""

    with pytest.raises(UsageError, match="something else is called ball_1"):
        parse(text)
    assert str(parse(text.replace("?ball-1", "?a-b"))[0]) == (
        "for all a_b: Ball (for all b: Ball (for all s: Slot (not (In(a_b, s) and In(b, s)) or not Free(slot_1))))"
    )


def test_text_in_parentheses_is_not_taken_for_pddl() -> None:
    assert parse("(not (Free(slot_1)))") == parse("(not (free slot_1))") == (~FREE("slot_1"),)
    assert parse("(Free(slot_1) or Free(slot_2))") == parse("(or (free slot_1) (free slot_2))")


@pytest.mark.parametrize(
    ("text", "column", "reason"),
    [
        ("(and (free slot_1)", 19, "expected '(' or ')'"),
        ("(free slot_1", 13, "expected ')', a name or a variable"),
        ("(free slot_1) (free slot_2)", 15, "expected the end"),
        ("(not (free slot_1) (free slot_2))", 20, "expected ')'"),
        ("(forall ?s (free ?s))", 9, "expected '('"),
        ("(forall (?s slot) (free ?s))", 13, "expected ')', '-' or a variable"),
        ("(imply (free slot_1))", 21, "expected '('"),
        ("(and free slot_1)", 6, "expected '(' or ')'"),
        ("(free\nslot_1\n$", 15, "expected ')'"),
    ],
)
def test_an_error_in_pddl_points_at_the_column(text: str, column: int, reason: str) -> None:
    with pytest.raises(GoalSyntaxError) as caught:
        parse(text)

    assert reason in str(caught.value)
    assert caught.value.column == column
    assert str(caught.value).splitlines()[-1] == "  " + " " * (column - 1) + "^"


def test_a_variable_may_be_called_as_pddl_spells_its_class() -> None:
    condition = exists(
        "ball", "tiny:Ball", all_of(IN_CONTAINER("ball", "slot_1"), ~IN_CONTAINER("tiny:Ball", "slot_2"))
    )

    assert parse("(exists (?ball - ball) (and (in ?ball slot_1) (not (in ball slot_2))))") == (condition,)
    assert parse("exists ball: Ball (In(ball, slot_1) and not In(Ball, slot_2))") == (condition,)


def test_an_empty_conjunction_or_disjunction_is_refused() -> None:
    with pytest.raises(UsageError, match="'and' joins nothing"):
        parse("(and)")


def test_a_variable_without_a_class_may_be_anything() -> None:
    with pytest.raises(UsageError, match="b is any Element, not only a Ball; say 'b: Ball' where it is bound"):
        parse("(exists (?b) (in ?b slot_1))")


def test_data_says_what_text_says() -> None:
    free = {"condition": "Free", "arguments": ["s"]}
    data = [
        {
            "if": {"condition": "at", "arguments": ["robot_1", "box A"]},
            "then": {"not": {**free, "arguments": ["slot_1"]}},
        },
        {"for_all": "s", "class": "Slot", "holds": {"any_of": [free, {"all_of": [free, {"not": free}]}]}},
        {"exists": "s", "class": "tiny:Slot", "holds": free},
    ]

    assert from_data(data) == (
        any_of(~AT_LOCATION("robot_1", "box_a"), ~FREE("slot_1")),
        for_all("s", "tiny:Slot", any_of(FREE("s"), all_of(FREE("s"), ~FREE("s")))),
        exists("s", "tiny:Slot", FREE("s")),
    )
    assert from_data(data[2]) == from_data(data)[2:]


@pytest.mark.parametrize(
    ("data", "answer"),
    [
        (None, "goal: expected an object with one of the fields condition, not, all_of, any_of, if, for_all, exists"),
        ([{"foo": 1}], "goal[0]: expected an object with one of the fields"),
        (
            [{"not": {"any_of": [{"condition": "Free", "arguments": 3}]}}],
            "goal[0].not.any_of[0].arguments: input should",
        ),
        ({"condition": "Free"}, "goal.arguments: field required"),
        ({"condition": "Free", "arguments": ["slot_1", 2]}, "goal.arguments[1]: input should be a valid string"),
        ({"not": {"condition": "Free", "arguments": []}, "or": []}, "goal.or: extra inputs are not permitted"),
        ({"any_of": []}, "goal.any_of: list should have at least 1 item"),
        ({"for_all": "s", "class": "Slot"}, "goal.holds: field required"),
    ],
)
def test_a_wrong_field_is_answered_with_its_path(data: object, answer: str) -> None:
    with pytest.raises(UsageError) as caught:
        from_data(data)

    assert answer in str(caught.value)


def test_a_wrong_name_in_data_is_answered_with_the_nearest() -> None:
    with pytest.raises(
        UnknownName, match=r"unknown element 'slot1' in Free, argument 1 \(slot\). Did you mean 'slot_1'"
    ):
        from_data({"condition": "Free", "arguments": ["slot1"]})


@pytest.mark.parametrize("depth", [100, 1000, 10_000])
def test_data_nested_too_deep_is_refused(depth: int) -> None:
    data: dict[str, object] = {"condition": "Free", "arguments": ["slot_1"]}
    for _ in range(depth):
        data = {"not": data}

    with pytest.raises(UsageError, match=r"nested deeper than 50 levels|maximum validation depth") as caught:
        from_data(data)
    assert len(str(caught.value)) < 300


@pytest.fixture(scope="module")
def described(tmp_path_factory: pytest.TempPathFactory) -> World:
    """A world whose ontology describes a ball: light and scanned."""
    folder = tmp_path_factory.mktemp("described")
    file = folder / "described.ttl"
    file.write_text(DESCRIBED, encoding="utf-8")
    ontology = Ontology.load((ontology_paths()[0] / "core.ttl", TINY_ONTOLOGY, file))
    facts = (
        "scene:ball_2 a tiny:Ball ; tiny:scanned true ; sk:in scene:box_a .",
        "scene:ball_3 a tiny:Ball ; tiny:scanned true ; sk:in scene:slot_2 .",
    )
    return load_scene(ontology, tiny_scene(folder, *facts))


DESCRIBED = """
@prefix d: <https://w3id.org/skiros-py/testing/described#> .
@prefix tiny: <https://w3id.org/skiros-py/testing/tiny#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
<https://w3id.org/skiros-py/testing/described> a owl:Ontology ;
    owl:imports <https://w3id.org/skiros-py/testing/tiny> .
d:known_ball a tiny:Ball , owl:NamedIndividual ; rdfs:label "known ball" ; tiny:scanned true .
d:shelf a tiny:Box , owl:NamedIndividual .
"""


@pytest.mark.parametrize("name", ["d:known_ball", '"known ball"', "known_ball"])
def test_an_abstract_individual_stands_for_whatever_fits_its_description(described: World, name: str) -> None:
    def holds(place: str) -> bool:
        (condition,) = parse_goal([f"In({name}, {place})"], described, CONDITIONS)
        assert parse_goal([goal_as_text([condition])], described, CONDITIONS) == (condition,)
        return bool(condition.evaluate(described))

    assert holds("box_a"), "ball_2 was scanned"
    assert not holds("box_b"), "red_ball_1 was not"
    assert holds("slot_2")
    assert (~IN_CONTAINER("d:known_ball", "box_b")).evaluate(described)


def test_an_abstract_individual_is_refused_where_one_element_is_needed(described: World) -> None:
    with pytest.raises(UsageError, match=r"d:shelf is abstract; At needs one element of the scene: .*box_a"):
        parse_goal(["At(robot_1, d:shelf)"], described, CONDITIONS)
    with pytest.raises(UsageError, match="d:known_ball is abstract; Holding needs one element of the scene: ball_1"):
        parse_goal(["Holding(gripper_1, d:known_ball)"], described, CONDITIONS)
    assert not HOLDING.abstract


def test_a_class_that_two_ontologies_call_alike_must_be_written_with_its_prefix(tmp_path: Path) -> None:
    file = tmp_path / "twin.ttl"
    file.write_text(
        DESCRIBED.replace("testing/described", "testing/twin")
        .replace("@prefix d:", "@prefix twin:")
        .partition("d:known")[0]
        + "twin:RedBall a owl:Class ; rdfs:subClassOf tiny:Ball .",
        encoding="utf-8",
    )
    ontology = Ontology.load((ontology_paths()[0] / "core.ttl", TINY_ONTOLOGY, file))
    world = load_scene(ontology, tiny_scene(tmp_path))

    with pytest.raises(UsageError, match="RedBall may be tiny:RedBall or twin:RedBall: write the one that is meant"):
        parse_goal(["In(RedBall, slot_1)"], world, CONDITIONS)
    goal = parse_goal(["In(twin:RedBall, slot_1)"], world, CONDITIONS)
    assert parse_goal([goal_as_text(goal)], world, CONDITIONS) == goal
