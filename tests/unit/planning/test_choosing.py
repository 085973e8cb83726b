"""Which planner is asked for what."""

from __future__ import annotations

import pytest

from skiros_py.errors import PlanningError, UsageError
from skiros_py.planning.planners.planner import Planner, Planners, lacking
from skiros_py.testing import GivenPlanner

CLASSICAL = frozenset({":strips", ":typing"})
TEMPORAL = CLASSICAL | {":durative-actions", ":fluents"}


class Named(GivenPlanner):
    """Takes what it is said to take."""

    def __init__(self, name: str, supports: frozenset[str]) -> None:
        super().__init__()
        self.name = name  # type: ignore[misc]
        self.supports = supports  # type: ignore[misc]
        self.closed = 0

    def close(self) -> None:
        self.closed += 1


def planners(*wanted: str, **supports: frozenset[str]) -> Planners:
    known = {name.replace("_", "-"): words for name, words in supports.items()}
    return Planners(known, lambda name: Named(name, known[name]), *wanted)


def names(found: Planners, *requirements: str) -> list[str]:
    return [planner.name for planner in found.fitting(requirements)]


ALL = {"zeal": CLASSICAL, "kairos": TEMPORAL, "aries": TEMPORAL, "fast_downward": CLASSICAL}


def test_fast_downward_is_asked_first_then_kairos_then_the_others_by_name() -> None:
    assert names(planners(**ALL), ":strips", ":typing") == ["fast-downward", "kairos", "aries", "zeal"]


def test_only_those_that_take_all_that_the_task_uses_are_asked() -> None:
    assert names(planners(**ALL), ":strips", ":durative-actions") == ["kairos", "aries"]


def test_the_one_that_somebody_wants_is_the_only_one() -> None:
    assert names(planners("zeal", **ALL), ":strips") == ["zeal"]
    assert names(planners("zeal", **ALL), ":durative-actions") == []


def test_where_none_fits_each_says_why_not() -> None:
    choice = planners(kairos=TEMPORAL, zeal=CLASSICAL)

    assert choice.why_none((":typing", ":adl")) == (
        "no planner takes :typing :adl: "
        "kairos does not take :conditional-effects :disjunctive-preconditions :equality :existential-preconditions "
        ":negative-preconditions :universal-preconditions; "
        "zeal does not take :conditional-effects :disjunctive-preconditions :equality :existential-preconditions "
        ":negative-preconditions :universal-preconditions"
    )
    assert planners().why_none((":strips",)) == "no planner takes :strips: none is installed"


@pytest.mark.parametrize(
    ("requirements", "supports", "missing"),
    [
        ((":strips",), (), ()),
        ((":negative-preconditions",), (":adl",), ()),
        ((":adl",), (":typing", ":strips"), True),
        ((":numeric-fluents",), (":fluents",), ()),
        ((":quantified-preconditions",), (":existential-preconditions",), (":universal-preconditions",)),
    ],
)
def test_words_that_are_short_for_others_count_as_these(
    requirements: tuple[str, ...], supports: tuple[str, ...], missing: object
) -> None:
    found = lacking(requirements, supports)

    assert bool(found) if missing is True else found == missing


def test_a_planner_is_made_once_and_only_when_those_before_it_did_not_do() -> None:
    made: list[str] = []

    def make(name: str) -> Planner:
        made.append(name)
        return Named(name, CLASSICAL)

    choice = Planners(("fast-downward", "kairos"), make)

    assert made == []
    next(choice.fitting((":strips",)))
    next(choice.fitting((":strips",)))
    assert made == ["fast-downward"]


def test_one_that_cannot_be_made_is_passed_over_and_named_when_it_is_missed() -> None:
    def make(name: str) -> Planner:
        if name == "fast-downward":
            raise UsageError("its wheel is broken")
        return Named(name, CLASSICAL)

    choice = Planners(("fast-downward", "zeal"), make)

    assert names(choice, ":strips") == ["zeal"]
    assert "fast-downward is not there (its wheel is broken)" in choice.why_none((":time",))


def test_closing_closes_what_was_made_and_nothing_is_asked_any_more() -> None:
    planner = Named("zeal", CLASSICAL)
    choice = Planners.only(planner)
    assert names(choice, ":strips") == ["zeal"]

    choice.close()
    choice.close()

    assert planner.closed == 2
    with pytest.raises(PlanningError, match="planning was stopped"):
        names(choice, ":strips")
