from __future__ import annotations

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.planning.domain.pddl import NameMap

KEYWORDS = ["and", "or", "not", "object", "define", "domain", "either", "when", "forall", "exists", "imply"]
names = st.one_of(
    st.text(min_size=1, max_size=12),
    st.sampled_from(
        [*KEYWORDS, "tiny:Ball", "other:Ball", "Ball", "ball", "BALL", "ball-2", "Größe", "größe", "7", "_"]
    ),
)


@settings(deadline=None)
@given(st.lists(names, max_size=30))
def test_names_map_to_pddl_and_back_without_collisions(given_names: list[str]) -> None:
    mapping = NameMap(given_names)

    assert [mapping.back(mapping.pddl(name)) for name in given_names] == given_names


@settings(deadline=None)
@given(names)
def test_every_pddl_name_is_plain(name: str) -> None:
    assert re.fullmatch(r"[a-z][a-z0-9_-]*", NameMap().pddl(name))


@settings(deadline=None)
@given(st.lists(names, max_size=20))
def test_the_same_names_in_the_same_order_give_the_same_map(given_names: list[str]) -> None:
    one, other = NameMap(given_names), NameMap(given_names)

    assert [one.pddl(name) for name in given_names] == [other.pddl(name) for name in given_names]


@settings(deadline=None)
@given(st.lists(names, min_size=1, max_size=20))
def test_mapping_a_name_again_gives_the_same_name(given_names: list[str]) -> None:
    mapping = NameMap()
    first = [mapping.pddl(name) for name in given_names]

    assert [mapping.pddl(name) for name in given_names] == first


@pytest.mark.parametrize("keyword", KEYWORDS)
def test_keywords_are_never_used(keyword: str) -> None:
    assert NameMap().pddl(keyword) not in KEYWORDS


def test_of_two_names_with_the_same_pddl_form_the_first_keeps_it() -> None:
    mapping = NameMap(["a:Ball", "b:Ball"])

    assert (mapping.pddl("a:Ball"), mapping.pddl("b:Ball")) == ("ball", "ball-2")


def test_camel_case_is_written_with_underscores() -> None:
    assert NameMap().pddl("sk:drivingPose") == "driving_pose"


def test_a_planner_may_answer_in_upper_case() -> None:
    mapping = NameMap(["box_a"])

    assert mapping.back("BOX_A") == "box_a"


def test_an_unmapped_name_is_refused() -> None:
    with pytest.raises(KeyError):
        NameMap(["box_a"]).back("box_b")
