"""What a body is made of and refers to: wrong things are refused where they are written, in words."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import inf, nan
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.behaviours import (
    AssertEffects,
    Check,
    Do,
    Fallback,
    ForEach,
    Guard,
    P,
    Parallel,
    Repeat,
    Retry,
    Sequence,
    Timeout,
    Wait,
)
from skiros_py.errors import DescriptionError, UnknownName
from skiros_py.skills.conditions import AllOf, Not, Nothing, Related
from skiros_py.skills.skill import Skill
from skiros_py.testing.tiny import AT_LOCATION, DRIVE

STEP = Do.of("step")
THERE = AT_LOCATION("Robot", "Location")


def wrong(value: object) -> Any:
    """What a type checker would not let pass."""
    return value


no_node = st.one_of(
    st.none(), st.text(), st.integers(), st.just(Do), st.lists(st.just(STEP)), st.just(THERE), st.just(P("Robot"))
)
no_count = st.one_of(st.integers(max_value=0), st.floats(), st.text(), st.booleans(), st.just((3,)))
no_time = st.one_of(st.sampled_from([nan, inf, -1.0, -0.001]), st.text(), st.booleans(), st.none())
no_conditions = st.sampled_from([(), (3,), (AT_LOCATION,), (THERE, None), (Related("sk:at", "a", "b"),)])


@given(
    st.sampled_from(
        [
            Sequence.of,
            Fallback.of,
            Parallel.of,
            lambda node: Sequence.of(STEP, node),
            lambda node: Retry(node, 2),
            lambda node: Repeat(node),
            lambda node: Timeout(node, 1.0),
            lambda node: Guard.of(node, THERE),
            lambda node: ForEach("x", "tiny:Box", node),
            lambda node: Skill(DRIVE, node),
        ]
    ),
    no_node,
)
def test_an_object_that_is_not_a_node_is_refused_at_its_definition(make: Callable[[Any], object], node: object) -> None:
    with pytest.raises(
        DescriptionError, match=r"it is made of nodes, given one by one, such as Do\.of\('drive'\), not"
    ):
        make(node)


@pytest.mark.parametrize("part", ["pre_sense", "finish", "post_sense"])
def test_every_part_of_a_skill_must_be_a_node(part: str) -> None:
    with pytest.raises(DescriptionError, match="of an implementation of skill 'drive': it is made of nodes"):
        replace(Skill(DRIVE, STEP), **{part: "step"})


@given(st.sampled_from([Retry, Repeat]), no_count)
def test_an_invalid_count_is_refused(make: Callable[..., object], times: object) -> None:
    with pytest.raises(DescriptionError, match="at least once, and a whole number of times, not"):
        make(STEP, times)


@given(st.sampled_from([Wait, AssertEffects, lambda time: Timeout(STEP, time)]), no_time)
def test_an_invalid_time_is_refused(make: Callable[..., object], seconds: object) -> None:
    with pytest.raises(DescriptionError, match="a number of seconds from 0, not"):
        make(seconds)


def test_a_timeout_of_zero_is_refused() -> None:
    with pytest.raises(DescriptionError, match=r"timeout: a time above 0 s, not 0"):
        Timeout(STEP, 0)


@given(st.sampled_from([Check, lambda conditions: Guard(STEP, conditions)]), no_conditions)
def test_an_object_that_is_not_a_condition_is_refused(make: Callable[..., object], conditions: object) -> None:
    with pytest.raises(DescriptionError, match="one or more conditions over parameters"):
        make(conditions)


@pytest.mark.parametrize(
    ("make", "right"),
    [
        (lambda: Do(wrong(3)), "do: the name of a module, not 3"),
        (lambda: Do(""), "do: the name of a module, not ''"),
        (lambda: Do("step", wrong(["x"])), "do: its arguments by key, not"),
        (lambda: P(wrong(3)), "P: the key of a parameter, not 3"),
        (lambda: Sequence(wrong([STEP])), "sequence: its parts are a tuple, not"),
        (lambda: Parallel.of(STEP, policy=wrong("all")), r"a policy such as Policy\.ALL, not 'all'"),
        (lambda: ForEach("", "tiny:Box", STEP), "the name of its element"),
        (lambda: ForEach("x", wrong(3), STEP), "a class such as sk:Box, not 3"),
        (lambda: ForEach("x", "Box", STEP), "a class such as sk:Box, not 'Box'"),
        (lambda: ForEach("x", "tiny:Box", STEP, wrong("full")), "where is a pattern such as"),
        (lambda: ForEach("x", "tiny:Box", STEP, wrong(THERE)), "where is a pattern such as"),
        (lambda: AssertEffects(1.0, wrong("held")), r"a tuple of keys such as \('held',\), not 'held'"),
        (lambda: AssertEffects(1.0, wrong((3,))), "the key of a postcondition, not 3"),
    ],
)
def test_every_other_field_of_a_node_is_checked(make: Callable[[], object], right: str) -> None:
    with pytest.raises(DescriptionError, match=right):
        make()


# ------------------------------------------------------------------ what it refers to


@pytest.mark.parametrize(
    ("body", "told"),
    [
        (Do.of("step", base=P("Basse")), "unknown parameter 'Basse' in the call of 'step' of .*'drive'.*mean 'Base'"),
        (Sequence.of(STEP, Retry(Do.of("step", a=P("Zz")), 2)), "'Zz' in the call of 'step'"),
        (Guard.of(STEP, AT_LOCATION("Robot", "Spot")), "'Spot' in At"),
        (Check.of(AT_LOCATION("Robot", "Spot")), "'Spot' in At"),
        (ForEach("x", "tiny:Box", STEP, Related("sk:at", "Robott", "x")), "'Robott' in 'for each x'.*mean 'Robot'"),
        (Sequence.of(ForEach("x", "tiny:Box", STEP), Do.of("step", a=P("x"))), "unknown parameter 'x'"),
    ],
    ids=["call", "below", "guard", "check", "query", "after the loop"],
)
def test_a_reference_to_an_unknown_parameter_is_refused_when_the_skill_is_made(body: Any, told: str) -> None:
    with pytest.raises(UnknownName, match=told):
        Skill(DRIVE, body)


@pytest.mark.parametrize("part", ["pre_sense", "finish", "post_sense"])
def test_all_parts_of_a_skill_are_checked(part: str) -> None:
    with pytest.raises(UnknownName, match="'Zz'"):
        replace(Skill(DRIVE, STEP), **{part: Do.of("step", a=P("Zz"))})


def test_loops_can_refer_to_their_own_and_enclosing_elements() -> None:
    inner = Guard.of(Do.of("step", a=P("x"), b=P("y")), AT_LOCATION("Robot", "x"))
    where = AllOf((Related("sk:on", "y", "x"), Not(Related("sk:at", "Robot", "y"))))

    Skill(DRIVE, ForEach("x", "tiny:Box", ForEach("y", "tiny:Ball", inner, where)))


def test_a_loop_variable_must_not_have_the_name_of_a_parameter() -> None:
    loop = ForEach("x", "tiny:Box", STEP)

    for body in (ForEach("Location", "tiny:Box", STEP), replace(loop, child=loop)):
        with pytest.raises(
            DescriptionError, match=r"of skill 'drive': something else is called so; choose another key"
        ):
            Skill(DRIVE, body)


def test_the_element_of_a_query_is_called_it_or_by_its_key() -> None:
    assert ForEach("x", "tiny:Box", STEP, Nothing("sk:in", "it")) == ForEach(
        "x", "tiny:Box", STEP, Nothing("sk:in", "x")
    )
