"""The tree of reasons, and what of it is said in a sentence."""

from __future__ import annotations

import pytest

from skiros_py.skills.conditions import AllOf, AnyOf, Exists, Not, Related, Verdict, all_of, any_of
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import AT_LOCATION, FREE, HOLDING, IN_CONTAINER

WORLD = tiny_world()
ELSEWHERE = "ball_1 is not in box_b: it is in box_a"


def test_a_sentence_contains_only_the_leaves_of_the_reason_tree() -> None:
    verdict = IN_CONTAINER("ball_1", "box_b").evaluate(WORLD)

    assert verdict.why == ELSEWHERE
    assert verdict.sentence == f"In(ball_1, box_b): {ELSEWHERE}"


def test_a_reason_shared_by_several_parts_is_given_once() -> None:
    twice = any_of(IN_CONTAINER("ball_1", "box_b"), all_of(FREE("slot_1"), IN_CONTAINER("ball_1", "box_b")))

    assert twice.evaluate(WORLD).why == ELSEWHERE


def test_the_reason_of_a_conjunction_contains_only_failed_parts() -> None:
    both = all_of(FREE("slot_1"), IN_CONTAINER("ball_1", "box_b"))

    assert both.evaluate(WORLD).why == ELSEWHERE


def test_the_reason_of_a_negated_disjunction_contains_the_parts_that_hold() -> None:
    pattern = Not(AnyOf((Related("sk:in", "b", "x"), Related("sk:in", "b", "y"))))

    verdict = pattern.evaluate(WORLD, {"b": "ball_1", "x": "box_a", "y": "box_b"})
    assert not verdict
    assert verdict.why == "ball_1 in box_a"


def test_a_failed_search_is_mentioned_only_without_a_better_reason() -> None:
    vain = Exists("s", "tiny:Slot", Related("sk:in", "b", "s"))
    near = Related("sk:in", "b", "x")
    binding = {"b": "ball_1", "x": "box_b"}

    assert AnyOf((near, vain)).evaluate(WORLD, binding).why == ELSEWHERE
    assert "no Slot makes it true" in vain.evaluate(WORLD, binding).why
    assert AllOf((vain, vain)).evaluate(WORLD, binding).why.startswith("all of these: no Slot makes it true")


@pytest.mark.parametrize("holds", [True, False])
def test_a_verdict_of_its_own_is_its_own_reason(holds: bool) -> None:
    assert Verdict(holds, "so it is").why == Verdict(holds, "so it is").sentence == "so it is"


def test_many_reasons_are_cut_short() -> None:
    verdict = Verdict(False, "all", tuple(Verdict(False, f"reason {n}") for n in range(9)))

    assert verdict.sentence == "all: reason 0; reason 1; reason 2; reason 3; reason 4; and 4 more"


def test_the_reason_of_a_failed_disjunction_contains_all_its_parts() -> None:
    either = any_of(AT_LOCATION("robot_1", "box_a"), HOLDING("gripper_1", "ball_1"))

    assert either.evaluate(WORLD).why == (
        "robot_1 is not at box_a: it is at unknown_location; ball_1 is not heldBy gripper_1: it is in box_a"
    )
