from __future__ import annotations

from itertools import combinations

from hypothesis import given
from hypothesis import strategies as st

from skiros_py.planning.explanation.contradictions import short

WANTED = st.lists(st.frozensets(st.sampled_from("abcd"), max_size=3), max_size=6)


def lacks(wanted: list[frozenset[str]], indices: tuple[int, ...]) -> bool:
    return len(frozenset[str]().union(*(wanted[i] for i in indices))) < len(indices)


@given(WANTED)
def test_a_reported_group_wants_fewer_things_than_it_has_members(wanted: list[frozenset[str]]) -> None:
    found = short(wanted)

    assert not found or lacks(wanted, found)


@given(WANTED)
def test_a_group_is_reported_exactly_if_some_group_wants_too_few_things(wanted: list[frozenset[str]]) -> None:
    groups = (group for size in range(1, len(wanted) + 1) for group in combinations(range(len(wanted)), size))

    assert bool(short(wanted)) == any(lacks(wanted, group) for group in groups)
