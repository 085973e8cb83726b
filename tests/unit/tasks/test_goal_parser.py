from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.errors import GoalSyntaxError, UnknownName, UsageError
from skiros_py.messages import messages_in
from skiros_py.skills.conditions import Condition, all_of, any_of, exists, for_all
from skiros_py.tasks.goals import parse_goal
from skiros_py.testing import CONDITIONS, tiny_world
from skiros_py.testing.tiny import AT_LOCATION, CARRIES, FREE, HOLDING, IN_CONTAINER

WORLD = tiny_world()


def parse(*texts: str) -> tuple[Condition, ...]:
    return parse_goal(texts, WORLD, CONDITIONS)


def test_conditions_are_joined_by_and_and_by_several_texts() -> None:
    expected = (IN_CONTAINER("ball_1", "slot_1"), AT_LOCATION("robot_1", "box_a"))

    assert parse("In(ball_1, slot_1) and At(robot_1, box_a)") == expected
    assert parse("In(ball_1, slot_1)", "At(robot_1, box_a)") == expected


def test_a_condition_said_twice_counts_once() -> None:
    assert parse("Free(slot_1) and Free(slot_1)") == (FREE("slot_1"),)


def test_not_negates_one_condition() -> None:
    assert parse("not Free(slot_1) and Free(slot_2)") == (~FREE("slot_1"), FREE("slot_2"))


def test_blanks_and_the_case_of_words_do_not_matter() -> None:
    assert parse("  in ( ball_1 ,slot_1 )  AND  NOT free(slot_2) ") == parse("In(ball_1, slot_1) and not Free(slot_2)")


def test_a_word_that_begins_with_a_keyword_is_a_word() -> None:
    with pytest.raises(UnknownName, match="unknown condition 'NotEmpty'"):
        parse("NotEmpty(slot_1)")


@pytest.mark.parametrize("name", ["RedBall", "tiny:RedBall"])
def test_a_class_may_be_given_where_the_word_allows(name: str) -> None:
    assert parse(f"In({name}, slot_1)") == (IN_CONTAINER("tiny:RedBall", "slot_1"),)


def test_an_element_may_be_given_by_its_label() -> None:
    world = tiny_world('scene:ball_7 a tiny:Ball ; rdfs:label "bluey" ; sk:in scene:box_a .')

    assert parse_goal(["In(bluey, slot_1)"], world, CONDITIONS) == (IN_CONTAINER("ball_7", "slot_1"),)


@pytest.mark.parametrize(
    ("text", "column", "reason"),
    [
        ("", 1, "expected"),
        ("In", 3, "expected '('"),
        ("In(", 4, "expected a name"),
        ("In()", 4, "expected a name"),
        ("In(ball_1 slot_1)", 11, "expected"),
        ("In(ball_1, slot_1", 18, "expected"),
        ("In(ball_1, slot_1) In(ball_1, slot_2)", 20, "expected 'and'"),
        ("In(ball_1, slot_1) and", 23, "expected"),
        ("In(ball_1, slot_1) xor Free(slot_1)", 20, "expected 'and', 'implies', 'or' or the end"),
        ("not Free(slot_1) not", 18, "expected 'and'"),
        ("(In(ball_1, slot_1)", 20, "expected ')'"),
        ("Free(slot_1) and or Free(slot_2)", 18, "expected a condition such as"),
        ('Free("slot_1)', 6, "expected a name"),
        ("for all s Slot (Free(s))", 11, "expected ':'"),
        ("for all s: Slot Free(s)", 17, "expected '(' or ','"),
        ("exists : Slot (Free(s))", 8, "expected a variable"),
        ("exists s: Slot ()", 17, "expected a condition such as"),
        ("In((ball_1), slot_1)", 4, "expected a name"),
        ("In(ball_1; slot_1)", 10, "expected"),
        ("In(ball_1, slot_1)!", 19, "expected"),
        ("$In(ball_1, slot_1)", 1, "expected"),
        ("In(ball_1, 7up)", 12, "expected"),
    ],
)
def test_an_error_points_at_the_column(text: str, column: int, reason: str) -> None:
    with pytest.raises(GoalSyntaxError) as caught:
        parse(text)

    assert caught.value.column == column
    assert reason in str(caught.value)
    assert str(caught.value).splitlines()[-1] == "  " + " " * (column - 1) + "^"


@pytest.mark.parametrize(
    ("text", "kind", "nearest"),
    [
        ("Inn(ball_1, slot_1)", "condition", "In"),
        ("holdin(gripper_1, ball_1)", "condition", "Holding"),
        ("In(bal_1, slot_1)", "element", "ball_1"),
        ("In(ball_1, slot1)", "element", "slot_1"),
        ("In(RedBal, slot_1)", "element", "RedBall"),
        ("At(robot_9, box_a)", "element", "robot_1"),
    ],
)
def test_an_unknown_name_is_answered_with_the_nearest(text: str, kind: str, nearest: str) -> None:
    with pytest.raises(UnknownName) as caught:
        parse(text)

    assert (caught.value.kind, caught.value.nearest) == (kind, nearest)


def test_a_class_is_refused_where_one_element_is_needed_and_those_there_are_named() -> None:
    with pytest.raises(UsageError, match=r"Box is a class; At needs one element of the scene: .*box_a, box_b"):
        parse("At(robot_1, Box)")


def test_an_element_of_the_wrong_class_is_refused_with_those_that_fit() -> None:
    with pytest.raises(
        UsageError, match=r"Free, argument 1 \(slot\): box_a is a Box, not a Slot. There is slot_1, slot_2"
    ):
        parse("Free(box_a)")


def test_a_class_of_the_wrong_kind_is_unknown_there() -> None:
    with pytest.raises(UnknownName, match=r"unknown element 'Slot' in In, argument 1 \(ball\)"):
        parse("In(Slot, slot_1)")


@pytest.mark.parametrize("text", ["In(ball_1)", "In(ball_1, slot_1, slot_2)"])
def test_the_wrong_number_of_arguments_is_answered_with_the_roles(text: str) -> None:
    with pytest.raises(UsageError, match=r"In takes 2 arguments \(ball: Ball, place: Container\), got \d"):
        parse(text)


conditions = st.one_of(
    st.builds(
        IN_CONTAINER, st.sampled_from(["ball_1", "tiny:Ball", "tiny:RedBall"]), st.sampled_from(["slot_1", "box_a"])
    ),
    st.builds(AT_LOCATION, st.just("robot_1"), st.sampled_from(["box_a", "floor", "unknown_location"])),
    st.builds(HOLDING, st.just("gripper_1"), st.sampled_from(["ball_1", "red_ball_1"])),
    st.builds(CARRIES, st.just("robot_1"), st.just("ball_1")),
    st.builds(FREE, st.sampled_from(["slot_1", "slot_2"])),
)


@settings(deadline=None)
@given(st.lists(st.tuples(conditions, st.booleans()), min_size=1, max_size=5, unique=True))
def test_what_conditions_print_parses_back_to_them(chosen: list[tuple[Condition, bool]]) -> None:
    goal = tuple(~condition if negated else condition for condition, negated in chosen)

    assert parse(" and ".join(map(str, goal))) == goal


@settings(deadline=None)
@given(st.text(alphabet="Inot(),and ball_1:Free\n\t9é", max_size=30))
def test_any_text_parses_or_is_answered_with_a_usage_error(text: str) -> None:
    try:
        goal = parse(text)
    except UsageError as error:
        answer = str(error)
    else:
        answer = " and ".join(map(str, goal))
    assert answer


LABELS = """
scene:ball_7 a tiny:Ball ; rdfs:label "ball_1" ; sk:in scene:box_a .
scene:ball_8 a tiny:Ball ; rdfs:label "RedBall" ; sk:in scene:box_a .
scene:ball_9 a tiny:Ball ; rdfs:label "bluey" ; sk:in scene:box_a .
"""


@pytest.mark.parametrize(
    ("name", "meant"),
    [("ball_1", "ball_1"), ("RedBall", "tiny:RedBall"), ("bluey", "ball_9")],
    ids=["id before label", "class before label", "label"],
)
def test_a_word_is_an_id_first_then_a_class_then_a_label(name: str, meant: str) -> None:
    world = tiny_world(LABELS)

    assert parse_goal([f"In({name}, slot_1)"], world, CONDITIONS) == (IN_CONTAINER(meant, "slot_1"),)


def test_an_element_whose_id_is_the_name_of_a_class_is_meant_before_the_class() -> None:
    world = tiny_world("scene:Giant a tiny:Ball ; sk:in scene:box_a .")

    assert parse_goal(["In(Giant, slot_1)"], world, CONDITIONS) == (IN_CONTAINER("Giant", "slot_1"),)


def test_a_part_without_a_label_does_not_stand_for_its_whole_class() -> None:
    world = tiny_world("scene:only a tiny:Giant ; sk:in scene:box_a .")

    assert world.element("only").label == "Giant"
    assert parse_goal(["In(Giant, slot_1)"], world, CONDITIONS) == (IN_CONTAINER("tiny:Giant", "slot_1"),)


def test_a_label_that_two_elements_have_stands_for_neither() -> None:
    twins = "".join(f'scene:twin_{n} a tiny:Ball ; rdfs:label "twin" ; sk:in scene:box_a . ' for n in (1, 2))

    with pytest.raises(UnknownName, match="unknown element 'twin'"):
        parse_goal(["In(twin, slot_1)"], tiny_world(twins), CONDITIONS)


def test_not_binds_closest_then_and_then_or_then_implies() -> None:
    one, two, held = FREE("slot_1"), FREE("slot_2"), HOLDING("gripper_1", "ball_1")
    words = "Free(slot_1)", "Free(slot_2)", "Holding(gripper_1, ball_1)"

    assert parse("not {} and {} or {}".format(*words)) == (any_of(all_of(~one, two), held),)
    assert parse("{} and {} implies {}".format(*words)) == (any_of(~all_of(one, two), held),)
    assert parse("{} implies {} implies {}".format(*words)) == (any_of(~one, any_of(~two, held)),)
    assert parse("not ({} or {}) AND {}".format(*words)) == (~any_of(one, two), held)
    assert parse("not not {}".format(*words)) == (one,)


def test_parentheses_that_say_nothing_change_nothing() -> None:
    assert parse("((Free(slot_1)) and (((Free(slot_2)))))") == (FREE("slot_1"), FREE("slot_2"))


def test_quantifiers_bind_variables_one_after_the_other() -> None:
    inner = for_all("s", "tiny:Slot", any_of(~IN_CONTAINER("b", "s"), ~FREE("s")))

    assert parse("FOR ALL b: Ball, s: tiny:Slot (In(b, s) implies not Free(s))") == (for_all("b", "tiny:Ball", inner),)
    assert parse("forall s:Slot (Free(s)) and not exists r: Robot (At(r, box_a))") == (
        for_all("s", "tiny:Slot", FREE("s")),
        ~exists("r", "sk:Robot", AT_LOCATION("r", "box_a")),
    )


def test_a_label_with_blanks_stands_in_double_quotes() -> None:
    world = tiny_world(r'scene:ball_7 a tiny:Ball ; rdfs:label "the \"best\" ball" ; sk:in scene:box_a .')

    assert parse('In("red ball one", "slot 2")') == (IN_CONTAINER("red_ball_1", "slot_2"),)
    assert parse_goal([r'In("the \"best\" ball", slot_1)'], world, CONDITIONS) == (IN_CONTAINER("ball_7", "slot_1"),)


def test_what_stands_in_quotes_is_no_variable() -> None:
    with pytest.raises(UnknownName, match="unknown element 's'"):
        parse('for all s: Slot (Free("s"))')


@pytest.mark.parametrize("name", ["all", "or", "and", "exists", "implies"])
def test_an_element_called_like_a_keyword_is_an_element(name: str) -> None:
    world = tiny_world(f"scene:{name} a tiny:Ball ; sk:in scene:box_a .")
    goal = (IN_CONTAINER(name, "slot_1"), ~IN_CONTAINER(name, "slot_2"))

    assert parse_goal([f"In({name}, slot_1) and not In({name}, slot_2)"], world, CONDITIONS) == goal


@pytest.mark.parametrize(
    ("text", "answer"),
    [
        ("exists b: Ball (Free(slot_1))", "exists b: b is no argument of Free(slot_1)"),
        ("exists b: Ball (exists b: Ball (In(b, slot_1)))", "in 'exists b': b is bound already around it"),
        ("exists ball_1: Ball (In(ball_1, slot_1))", "something else is called ball_1; call the variable otherwise"),
        ("exists Ball: Ball (In(Ball, slot_1))", "something else is called Ball; call the variable otherwise"),
        ("exists b: Ball (Free(b))", "Free, argument 1 (slot): b is any Ball, not only a Slot; say 'b: Slot'"),
        ("exists b: Bal (In(b, slot_1))", "unknown class 'Bal' in 'exists b'. Did you mean 'Ball'?"),
        ("exists ball: Ball (In(bal, slot_1))", "unknown element 'bal' in In, argument 1 (ball)."),
        ("(free ?x)", "Free, argument 1 (slot): no quantifier around it binds ?x (bound: none is)"),
        ("(exists (?s - slot) (free ?t))", "no quantifier around it binds ?t (bound: ?s)"),
    ],
)
def test_a_variable_out_of_place_is_refused(text: str, answer: str) -> None:
    with pytest.raises(UsageError) as caught:
        parse(text)

    assert answer in str(caught.value)


def test_a_contradiction_is_no_fault_of_the_text() -> None:
    assert parse("Free(slot_1) and not Free(slot_1)") == (FREE("slot_1"), ~FREE("slot_1"))


@pytest.mark.parametrize(
    "text",
    [
        "not " * 1000 + "Free(slot_1)",
        "Free(slot_1) or not (" * 1000 + "Free(slot_2)" + ")" * 1000,
        " implies ".join(["Free(slot_1)"] * 1000),
        "(not " * 1000 + "(free slot_1)" + ")" * 1000,
    ],
    ids=["not", "or", "implies", "PDDL"],
)
def test_a_too_deeply_nested_goal_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match="nested deeper than 50 levels"):
        parse(text)


def test_a_thousand_parentheses_and_ten_thousand_conditions_are_read() -> None:
    (either,) = parse(" or ".join(["Free(slot_1)", "Free(slot_2)"] * 1000))  # as many as may be looked at

    assert parse("(" * 1000 + "Free(slot_1)" + ")" * 1000) == (FREE("slot_1"),)
    assert parse(" and ".join(["Free(slot_1)", "Free(slot_2)"] * 5000)) == (FREE("slot_1"), FREE("slot_2"))
    assert either.evaluate(WORLD)


def test_unclosed_parentheses_are_reported_at_the_end() -> None:
    with pytest.raises(GoalSyntaxError) as caught:
        parse("(" * 10_000)

    assert caught.value.column == 10_001


def _all_of_many(depth: int) -> str:
    variables = [f"b{n}" for n in range(1, depth + 1)]
    declared = ", ".join(f"{variable}: Ball" for variable in variables)
    return f"exists {declared} ({' and '.join(f'In({variable}, slot_1)' for variable in variables)})"


def test_quantifiers_in_one_another_may_stand_for_so_many_combinations_only() -> None:
    assert len(parse(_all_of_many(7))) == 1  # 7 words for each of 2^7 combinations
    with pytest.raises(UsageError, match=r"has to be looked at in 22528 places .*, and 2000 are allowed"):
        parse(_all_of_many(11))


def test_all_conditions_of_a_goal_count_together() -> None:
    goals = [f"{_all_of_many(7)} or Free({slot})" for slot in ("slot_1", "slot_2")]

    assert len(parse(*goals)) == 2
    with pytest.raises(UsageError, match="has to be looked at in 2694 places"):
        parse(*goals, f"not {_all_of_many(7)}", "Free(slot_1)", "Free(slot_2)", "Free(slot_1) or Free(slot_2)")


def test_a_class_that_stands_for_very_many_elements_counts() -> None:
    world = tiny_world("".join(f"scene:more_{n} a tiny:Ball ; sk:in scene:box_a . " for n in range(200)))
    wanted = " or ".join(["In(Ball, slot_1)"] * 100)

    with pytest.raises(UsageError, match="has to be looked at in 2100 places"):
        parse_goal([wanted], world, CONDITIONS)


@pytest.mark.parametrize(
    ("text", "template"),
    [
        ("In(ball_1", "goal, column {column}: {reason}"),
        ("In(ball_1)", "{condition} takes {count} arguments ({roles}), got {given}"),
        ("At(robot_1, ball_1)", "{where}: {name} is a {kind}, not a {wanted}. There is {things}."),
    ],
)
def test_what_is_wrong_with_a_goal_can_be_said_in_other_languages(text: str, template: str) -> None:
    with pytest.raises(UsageError) as wrong:
        parse(text)

    said = messages_in(wrong.value.args)[str(wrong.value)]
    assert template in (
        said["template"],
        *(one["template"] for one in said["values"].values() if isinstance(one, dict)),
    )
