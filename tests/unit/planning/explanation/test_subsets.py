from __future__ import annotations

from collections.abc import Sequence

from hypothesis import given
from hypothesis import strategies as st

from skiros_py.planning.explanation.explaining import conflict_of, smallest_unsolvable
from skiros_py.skills.conditions import Condition
from skiros_py.testing.tiny import FREE

GOAL = tuple(FREE(f"slot_{n}") for n in range(8))


def smallest(goal: Sequence[Condition], bad: Sequence[Condition], *, known: bool = True) -> tuple[Condition, ...]:
    def reachable(some: Sequence[Condition]) -> bool | None:
        return not set(bad) <= set(some) if known else None

    return smallest_unsolvable(goal, reachable)


@given(st.sets(st.sampled_from(GOAL), min_size=1))
def test_the_smallest_subset_is_exactly_the_conflicting_conditions(bad: set[Condition]) -> None:
    assert set(smallest(GOAL, tuple(bad))) == bad


def test_without_a_proof_of_the_planner_no_condition_is_left_out() -> None:
    assert smallest(GOAL, GOAL[:2], known=False) == GOAL


def test_a_planner_is_asked_a_bounded_number_of_times() -> None:
    calls: list[Sequence[Condition]] = []
    many = tuple(FREE(f"slot_{n}") for n in range(100))

    def reachable(some: Sequence[Condition]) -> bool | None:
        calls.append(some)
        return False

    smallest_unsolvable(many, reachable)

    assert len(calls) <= 16


def test_a_conflict_names_its_conditions() -> None:
    assert (
        conflict_of(GOAL[:2]).text
        == "Free(slot_0) and Free(slot_1) could each be reached, but not all of them together"
    )
