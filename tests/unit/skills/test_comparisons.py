from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.errors import DescriptionError
from skiros_py.geometry import Pose
from skiros_py.skills.conditions import AllOf, AnyOf, Compare, Exists, Not, Pattern, Verdict
from skiros_py.skills.conditions.condition import Comparison
from skiros_py.testing import tiny_world
from skiros_py.world.overlay import Overlay

WORLD = tiny_world(
    "scene:robot_1 tiny:charge 40.0 . scene:ball_1 tiny:scanned true . ",
    "scene:door_1 a tiny:Door ; sk:on scene:floor . ",
    'scene:door_2 a tiny:Door ; tiny:opening "ajar" ; sk:on scene:floor .',
)


def of(pattern: Pattern, **binding: str) -> Verdict:
    return pattern.evaluate(WORLD, binding)


def charge(op: Any, value: Any) -> Compare:
    return Compare("tiny:charge", op, "robot", value)


@pytest.mark.parametrize(
    ("op", "value", "holds"),
    [("=", 40, True), ("!=", 40, False), ("<", 40, False), ("<=", 40, True), (">", 39.5, True), (">=", 41, False)],
)
def test_numbers_compare_in_six_ways(op: str, value: float, holds: bool) -> None:
    assert of(charge(op, value), robot="robot_1").holds is holds


def test_a_failed_comparison_gives_the_actual_value() -> None:
    assert of(charge(">=", 50), robot="robot_1").text == "the charge of robot_1 is 40, not at least 50"
    assert of(charge("<", 50), robot="robot_1").text == "the charge of robot_1 is 40"


def test_truth_values_are_not_numbers() -> None:
    assert of(Compare("tiny:scanned", "=", "ball", True), ball="ball_1")
    verdict = of(Compare("tiny:scanned", "=", "ball", 1), ball="ball_1")
    assert not verdict
    assert verdict.text == "the scanned of ball_1 is true (truth value): it cannot be compared with 1"


def test_a_text_and_a_number_are_neither_equal_nor_different_and_the_reason_says_why() -> None:
    for op in ("=", "!=", "<"):
        verdict = of(Compare("tiny:opening", op, "door", 3), door="door_2")
        assert not verdict
        assert verdict.text == "the opening of door_2 is 'ajar' (text): it cannot be compared with 3"


def test_a_pose_cannot_be_compared() -> None:
    overlay = Overlay(WORLD)
    overlay.set_value("ball_1", "sk:pose", Pose.of(1.0, 0.0, 0.0))

    assert not Compare("sk:pose", "=", "ball", "1 0 0 0 0 0").evaluate(overlay, {"ball": "ball_1"})


def test_comparisons_of_a_missing_value_fail_and_their_negations_hold() -> None:
    equal, other = (Compare("tiny:scanned", op, "ball", True) for op in ("=", "!="))

    assert of(equal, ball="red_ball_1").text == "red_ball_1 has no scanned"
    assert not of(other, ball="red_ball_1")
    assert of(Not(equal), ball="red_ball_1")


def test_a_comparison_uses_the_value_of_the_class() -> None:
    assert of(Compare("tiny:opening", "=", "door", "closed"), door="door_1")
    assert not of(Compare("tiny:opening", "=", "door", "closed"), door="door_2")


@pytest.mark.parametrize(
    ("op", "value", "text"),
    [
        ("<", "open", "'<' compares numbers, and 'open' is a text: use = or !="),
        (">=", True, "'>=' compares numbers, and true is a truth value: use = or !="),
        ("==", 1, "'==' does not compare: use one of = != < <= > >="),
        ("=", None, "compare with a text, a finite number, true or false, not with None"),
        ("<", float("nan"), "compare with a text, a finite number, true or false, not with nan"),
        ("=", (1.0, 2.0), r"compare with a text, a finite number, true or false, not with (1.0, 2.0)"),
    ],
)
def test_an_invalid_comparison_is_refused_at_its_definition(op: Any, value: Any, text: str) -> None:
    with pytest.raises(DescriptionError) as caught:
        charge(op, value)

    assert str(caught.value) == text


def test_comparisons_combine_with_all_any_not_and_exists() -> None:
    ajar = Compare("tiny:opening", "=", "door", "ajar")
    open_ = Compare("tiny:opening", "=", "door", "open")

    assert of(Exists("door", "tiny:Door", AnyOf((open_, ajar))))
    assert not of(Exists("door", "tiny:Door", AllOf((open_, ajar))))
    assert of(AllOf((Not(open_), charge(">", 1))), door="door_1", robot="robot_1")


def test_renaming_a_comparison_renames_its_subject_only() -> None:
    assert charge("<", 3).rename({"robot": "r", "tiny:charge": "x"}) == Compare("tiny:charge", "<", "r", 3)


constants = st.one_of(st.booleans(), st.integers(), st.floats(allow_nan=False, allow_infinity=False), st.text())


@given(constants, st.one_of(st.none(), constants))
def test_a_value_is_equal_or_different_exactly_if_it_exists_and_has_the_same_type(wanted: Any, present: Any) -> None:
    equal, other = Comparison("=", wanted).allows(present), Comparison("!=", wanted).allows(present)
    is_number = [isinstance(v, int | float) and not isinstance(v, bool) for v in (wanted, present)]

    assert (equal or other) == (all(is_number) or type(wanted) is type(present))
    assert not (equal and other)


@given(st.sampled_from(["=", "!=", "<", "<=", ">", ">="]), st.floats(-9, 9), st.one_of(st.none(), constants))
def test_planning_and_evaluation_agree_on_comparisons(op: Any, wanted: float, present: Any) -> None:
    comparison = Comparison(op, wanted)

    assert comparison.judge("it", present, "none").holds == comparison.allows(present)
