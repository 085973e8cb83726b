from __future__ import annotations

import pytest

from skiros_py.tasks.report import ConditionReport, GoalReport


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
