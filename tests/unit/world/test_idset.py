"""Sets of ids answer as Python's sets do, sorted, and none ever changes."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from skiros_py.world.ids import EMPTY, IdSet

NAMES = [f"part_{number}" for number in range(80)]
steps = st.lists(st.tuples(st.sampled_from(NAMES), st.booleans()), max_size=200)


def built(names: list[str]) -> IdSet:
    found = EMPTY
    for name in names:
        found = found.with_(name)
    return found


def same(found: IdSet, expected: set[str]) -> bool:
    return (
        found.ids() == tuple(sorted(expected))
        and len(found) == len(expected)
        and all((name in found) == (name in expected) for name in NAMES)
    )


@given(st.sets(st.sampled_from(NAMES)), steps)
def test_an_id_set_equals_a_python_set_after_any_additions_and_removals(
    first: set[str], steps: list[tuple[str, bool]]
) -> None:
    found, expected = built(sorted(first)), set(first)
    for name, comes in steps:
        found = found.with_(name) if comes else found.without(name)
        (expected.add if comes else expected.discard)(name)

    assert same(found, expected)


@given(st.sets(st.sampled_from(NAMES)), st.sampled_from(NAMES))
def test_deriving_a_set_does_not_change_the_original(names: set[str], name: str) -> None:
    found = built(sorted(names))

    more, less = found.with_(name), found.without(name)

    assert same(found, names)
    assert same(more, names | {name})
    assert same(less, names - {name})


@given(st.integers(0, 700), st.integers(0, 50), st.integers(0, 800))
def test_the_first_ids_after_one_are_found_in_sets_of_every_size(size: int, limit: int, after: int) -> None:
    names = [f"part_{number:03}" for number in range(size)]
    found = built(names[::-1])

    assert found.some(limit, f"part_{after:03}") == tuple(names[after + 1 :][:limit])
    assert found.some(limit) == tuple(names[:limit])


def test_sets_of_one_and_of_several_blocks_give_the_same_answers() -> None:
    for size in (255, 256, 257, 258):
        names = {f"part_{number:03}" for number in range(size)}
        found = built(sorted(names, reverse=True))

        assert found.ids() == tuple(sorted(names))
        assert found.without("part_000").ids() == tuple(sorted(names - {"part_000"}))
        assert found.without("part_000").with_("part_000").ids() == tuple(sorted(names))


def test_an_operation_without_effect_returns_the_same_set() -> None:
    for size in (3, 60):
        found = built(NAMES[:size])

        assert found.with_(NAMES[0]) is found
        assert found.without("nobody") is found


def test_the_empty_set_holds_nothing() -> None:
    assert EMPTY.ids() == ()
    assert len(EMPTY) == 0
    assert "part_1" not in EMPTY
    assert EMPTY.without("part_1") is EMPTY


def test_an_id_set_contains_only_strings() -> None:
    assert 5 not in built(NAMES[:3])
    assert None not in built(NAMES)
