from __future__ import annotations

from dataclasses import replace

import pytest

from skiros_py.tasks.report import ConditionReport, GoalReport, Outcome, StepReport


def report(*pairs: tuple[bool, bool | None], stopped: bool = False) -> GoalReport:
    conditions = tuple(ConditionReport(f"C{n}", believed, true, 1) for n, (believed, true) in enumerate(pairs))
    return GoalReport(conditions, (), 1.0, 0.1, stopped=stopped)


@pytest.mark.parametrize(
    ("pairs", "reached"),
    [
        ([(True, None)], True),
        ([(False, None)], False),
        ([(True, None), (False, None)], False),
        ([(True, False)], False),
        ([(False, True)], True),
        ([], True),
    ],
)
def test_truth_counts_where_there_is_one_and_belief_elsewhere(
    pairs: list[tuple[bool, bool | None]], reached: bool
) -> None:
    assert report(*pairs).reached is reached


def test_a_stopped_goal_is_not_reached() -> None:
    assert not report((True, None), stopped=True).reached


def test_truth_is_put_beside_each_belief() -> None:
    judged = report((True, None), (False, None)).with_truth((False, True))

    assert [(c.believed, c.true) for c in judged.conditions] == [(True, False), (False, True)]


def test_one_truth_for_each_condition_is_required() -> None:
    with pytest.raises(ValueError, match="argument"):
        report((True, None)).with_truth((True, False))


def test_a_report_reads_as_text() -> None:
    lines = str(report((True, False))).splitlines()

    assert lines == ["C0: believed yes, truth no, tries 1", "goal not reached in 1.0 s simulated, 0.1 s wall"]


def ended(**fields: object) -> GoalReport:
    step = StepReport("pick", {}, 0.0, 1.0)
    return replace(GoalReport((ConditionReport("C", True, None, 1),), (step,), 1.0, 0.1), **fields)  # type: ignore[arg-type]


MISSING = ConditionReport("D", False, None, 3, "it slipped")


@pytest.mark.parametrize(
    ("fields", "outcome"),
    [
        ({}, Outcome.REACHED),
        ({"steps": ()}, Outcome.HELD_ALREADY),
        ({"stopped": True}, Outcome.STOPPED),
        ({"conditions": (MISSING,)}, Outcome.NOT_REACHED),
        ({"conditions": (MISSING, ConditionReport("C", True, None, 1))}, Outcome.PARTLY_REACHED),
        ({"conditions": (MISSING, ConditionReport("C", True, None, 0))}, Outcome.NOT_REACHED),
        ({"conditions": (MISSING,), "steps": (), "no_plan": ("why",)}, Outcome.NO_PLAN),
        ({"fault": "the planner broke"}, Outcome.NOT_REACHED),
    ],
)
def test_the_outcome_says_it_in_two_words(fields: dict[str, object], outcome: Outcome) -> None:
    assert ended(**fields).outcome is outcome


def test_why_it_ended_before_its_time_is_in_the_text() -> None:
    assert "the planner broke" in str(ended(fault="the planner broke"))
