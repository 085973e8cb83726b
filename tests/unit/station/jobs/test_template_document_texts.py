"""Structured goals are written as texts that say the same, whatever the names in them."""

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel
from random_goals import random_goal

from skiros_py.errors import UsageError
from skiros_py.station.jobs.template_document import goal_texts
from skiros_py.tasks.goals import goal_as_data, parse_goal
from skiros_py.tasks.goals.forms import FORMS, Name, read
from skiros_py.testing.tiny import CONDITIONS, tiny_world

names = st.text(st.characters(blacklist_categories=["Cs"]), min_size=1, max_size=12)
words = st.sampled_from(["InKit", "On", "ObjectAtLocation"])
plain = st.builds(lambda word, args: {"condition": word, "arguments": args}, words, st.lists(names, min_size=1))
goals = st.recursive(
    plain,
    lambda inner: st.one_of(
        inner.map(lambda one: {"not": one}),
        st.lists(inner, min_size=2, max_size=3).map(lambda some: {"all_of": some}),
        st.lists(inner, min_size=2, max_size=3).map(lambda some: {"any_of": some}),
        st.tuples(inner, inner).map(lambda two: {"if": two[0], "then": two[1]}),
        st.tuples(names, inner).map(lambda two: {"for_all": "c", "class": two[0], "holds": two[1]}),
        st.tuples(names, inner).map(lambda two: {"exists": "p", "class": two[0], "holds": two[1]}),
    ),
    max_leaves=6,
)


def without_marks(form):
    """Leaves out whether a name can be a variable: in quotes it cannot, and as data it may."""
    if isinstance(form, BaseModel):
        return type(form), [without_marks(value) for _, value in form]
    if isinstance(form, list):
        return [without_marks(one) for one in form]
    return form.text if isinstance(form, Name) else form


@given(goals)
def test_the_text_of_a_structured_goal_parses_to_the_same_goal(goal):
    (text,) = goal_texts(goal)
    (form,) = FORMS.validate_python([goal])
    assert without_marks(read(text)) == without_marks(form)


@pytest.mark.parametrize("seed", range(40))
def test_a_goal_means_the_same_as_text_and_as_data(seed):
    world = tiny_world()
    goal = random_goal(random.Random(seed), world)
    assert parse_goal(goal_texts(goal_as_data(goal)), world, CONDITIONS) == goal


def test_goal_texts_are_kept_unchanged_and_in_order():
    structured = {"condition": "On", "arguments": ["a b", "c"]}
    assert goal_texts(["In(x, y)", structured, "On(a,b)"]) == ("In(x, y)", 'On("a b", c)', "On(a,b)")


def test_a_structured_implication_is_written_with_implies():
    full, empty = ({"condition": word, "arguments": ["box"]} for word in ("Full", "Empty"))
    assert goal_texts({"if": full, "then": {"not": empty}}) == ("(Full(box)) implies (not (Empty(box)))",)


@pytest.mark.parametrize(
    ("goal", "said"),
    [
        ({"condition": "In"}, r"goal\.arguments: is missing"),
        ([{"not": {"all_of": []}}], r"goal\[0\]\.not\.all_of"),
        ([{"what": 1}], r"goal\[0\]: expected an object with one of the fields condition, not"),
        ({"condition": "In(x) or On", "arguments": ["x"]}, r"unknown condition 'In\(x\) or On'"),
        ({"for_all": "a b", "class": "Ball", "holds": {"condition": "In", "arguments": ["x"]}}, "be a variable"),
        ({"condition": "In", "arguments": [""]}, "empty"),
    ],
)
def test_an_invalid_structured_goal_is_refused_with_the_path_of_the_fault(goal, said):
    with pytest.raises(UsageError, match=said):
        goal_texts(goal)


def test_a_too_deeply_nested_goal_is_refused():
    goal = {"condition": "In", "arguments": ["x"]}
    for _ in range(100):
        goal = {"not": goal}
    with pytest.raises(UsageError, match="nested deeper"):
        goal_texts(goal)
