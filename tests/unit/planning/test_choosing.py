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


def test_only_planners_that_support_all_used_features_are_asked() -> None:
    assert names(planners(**ALL), ":strips", ":durative-actions") == ["kairos", "aries"]


def test_an_explicitly_chosen_planner_is_the_only_one_asked() -> None:
    assert names(planners("zeal", **ALL), ":strips") == ["zeal"]
    assert names(planners("zeal", **ALL), ":durative-actions") == []


def test_if_no_planner_fits_each_one_is_listed_with_its_reason() -> None:
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
def test_requirement_abbreviations_are_expanded(
    requirements: tuple[str, ...], supports: tuple[str, ...], missing: object
) -> None:
    found = lacking(requirements, supports)

    assert bool(found) if missing is True else found == missing


def test_a_planner_is_created_once_and_only_after_the_previous_ones_failed() -> None:
    made: list[str] = []

    def make(name: str) -> Planner:
        made.append(name)
        return Named(name, CLASSICAL)

    choice = Planners(("fast-downward", "kairos"), make)

    assert made == []
    next(choice.fitting((":strips",)))
    next(choice.fitting((":strips",)))
    assert made == ["fast-downward"]


def test_a_planner_that_cannot_be_created_is_skipped_and_named_if_no_other_works() -> None:
    def make(name: str) -> Planner:
        if name == "fast-downward":
            raise UsageError("its wheel is broken")
        return Named(name, CLASSICAL)

    choice = Planners(("fast-downward", "zeal"), make)

    assert names(choice, ":strips") == ["zeal"]
    assert "fast-downward is not there (its wheel is broken)" in choice.why_none((":time",))


def test_closing_closes_all_created_planners_and_refuses_later_requests() -> None:
    planner = Named("zeal", CLASSICAL)
    choice = Planners.only(planner)
    assert names(choice, ":strips") == ["zeal"]

    choice.close()
    choice.close()

    assert planner.closed == 2
    with pytest.raises(PlanningError, match="planning was stopped"):
        names(choice, ":strips")
