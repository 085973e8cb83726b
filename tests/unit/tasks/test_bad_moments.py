"""Stops and halts at bad moments: before the first cycle, while it plans, in a long step, twice, as it completes."""

from __future__ import annotations

import gc

import pytest

from skiros_py.behaviours import AssertEffects, Sequence, Wait
from skiros_py.errors import PlanningError, UsageError
from skiros_py.planning.plan import Step
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.planners.planner import Answer
from skiros_py.ports.values import Pending
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.report import Outcome
from skiros_py.tasks.trace import TraceEventKind
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import DRIVE, PICK, PLACE, pretend

GOAL = "In(ball_1, slot_1)"
LONG = tuple(pretend(skill, Sequence.of(Wait(30.0), AssertEffects(0.0))) for skill in (DRIVE, PICK, PLACE))


def begin(bench: Bench, goal: str = GOAL) -> TaskHandle:
    return bench.tasks.begin(bench.goal(goal))


def what(task: TaskHandle) -> list[TraceEventKind]:
    return [entry.what for entry in task.trace.entries]


def test_a_task_that_is_halted_before_its_first_cycle_is_over_with_a_report() -> None:
    with Bench(tiny_world()) as bench:
        task = begin(bench)
        bench.cycle.stop_all("somebody hit the button")

        assert bench.tasks.active == ()
    assert task.done
    assert task.report is not None
    assert task.report.fault == "somebody hit the button"
    assert task.report.conditions[0].reason == "somebody hit the button"
    assert what(task) == [TraceEventKind.BEGUN, TraceEventKind.FINISHED]


def test_a_sequence_that_is_halted_before_its_first_cycle_is_over_with_a_report() -> None:
    with Bench(tiny_world()) as bench:
        task = bench.tasks.execute([Step("drive", {"Location": "box_a"})])
        bench.cycle.stop_all("somebody hit the button")

    assert task.done
    assert task.report is not None
    assert not task.report.reached


def test_a_task_that_is_stopped_before_its_first_cycle_does_nothing() -> None:
    with Bench(tiny_world()) as bench:
        task = begin(bench)
        task.stop("changed my mind")
        bench.until(lambda: task.done, limit=0.1)

    assert task.report is not None
    assert (task.report.outcome, task.report.steps) == (Outcome.STOPPED, ())


def test_unreached_conditions_of_a_stopped_task_give_the_stop_as_reason() -> None:
    with Bench(tiny_world(), LONG) as bench:
        task = begin(bench)
        bench.advance(1.0)
        task.stop("changed my mind")
        bench.until(lambda: task.done)

    assert task.report is not None
    assert [c.reason for c in task.report.conditions] == ["stopped before it was reached"]


def test_a_halt_in_a_long_step_tells_its_end_and_the_next_task_runs_after_a_reset() -> None:
    with Bench(tiny_world(), LONG) as bench:
        task = begin(bench)
        bench.advance(1.0)
        bench.cycle.stop_all("a hand was seen")
        assert what(task)[-2:] == [TraceEventKind.CANCELLED, TraceEventKind.FINISHED]
        assert task.trace.entries[-2].text == "base_1: drive box_a is cancelled: a hand was seen"
        bench.cycle.reset()
        again = begin(bench, "At(robot_1, box_b)")
        bench.until(lambda: again.done)

    assert again.report is not None
    assert again.report.reached


def test_a_stop_in_a_long_step_ends_it_in_a_few_cycles_also_when_it_is_said_twice() -> None:
    with Bench(tiny_world(), LONG) as bench:
        task = begin(bench)
        bench.advance(1.0)
        task.stop("enough")
        task.stop("enough, I said")
        bench.until(lambda: task.done, limit=0.1)

    assert what(task).count(TraceEventKind.STOPPED) == 1
    assert what(task).count(TraceEventKind.CANCELLED) == 1


@pytest.mark.parametrize("before", range(4))
def test_a_stop_around_the_moment_of_completion_gives_a_report_that_is_true(before: int) -> None:
    with Bench(tiny_world()) as bench:
        begin(bench)
        length = round(bench.until(lambda: not bench.tasks.active) / bench.cycle.board.period)
    with Bench(tiny_world()) as bench:
        task = begin(bench)
        for _ in range(length - before):
            bench.cycle.step()
        task.stop("just now")
        bench.until(lambda: task.done, limit=0.1)

        assert task.report is not None
        assert task.report.conditions[0].believed == bench.world.related("ball_1", "sk:in", "slot_1")
    assert task.report.reached == task.report.conditions[0].believed
    assert what(task).count(TraceEventKind.FINISHED) == 1


def test_what_breaks_in_a_task_itself_is_in_its_report_and_is_no_stop() -> None:
    def breaks(*_: object, **__: object) -> None:
        raise ValueError("no such thing")

    with Bench(tiny_world()) as bench:
        run, task = bench.tasks.execute([Step("drive", {"Location": "box_a"})]), begin(bench)
        task.before_step(breaks)
        run.before_step(breaks)
        bench.until(lambda: task.done and run.done, limit=5.0)

    for one in (task, run):
        assert one.report is not None
        assert one.report.fault.startswith("it broke: ValueError: no such thing")
        assert one.report.outcome is Outcome.NOT_REACHED


# ------------------------------------------------------------------ planners that break while a task is under way


class Breaks(FastDownward):
    """Plans so often, and then breaks."""

    def __init__(self, after: int) -> None:
        super().__init__()
        self._left = after

    def solve(self, domain: str, problem: str) -> Pending[Answer]:
        if not self._left:
            raise PlanningError("the planner was killed")
        self._left -= 1
        return super().solve(domain, problem)


def test_a_planner_that_breaks_at_once_is_the_fault_in_the_report() -> None:
    with Bench(tiny_world(), planner=Breaks(0)) as bench:
        task = begin(bench)
        bench.until(lambda: task.done, limit=1.0)

        assert bench.tasks.active == ()
    assert task.report is not None
    assert "the planner was killed" in task.report.fault
    assert (task.report.outcome, task.report.steps) == (Outcome.NOT_REACHED, ())


def test_a_planner_that_breaks_when_it_is_needed_again_is_the_reason_in_the_report_and_nothing_runs_on() -> None:
    with Bench(tiny_world(), planner=Breaks(1)) as bench:
        task = begin(bench)
        bench.until(lambda: TraceEventKind.STARTED in what(task))
        with bench.world.transaction("somebody", "moved it") as tx:
            tx.place("ball_1", "sk:in", "box_b")
        bench.until(lambda: task.done, limit=5.0)

    assert task.report is not None
    assert "the planner was killed" in task.report.conditions[0].reason
    assert what(task).count(TraceEventKind.STARTED) == what(task).count(TraceEventKind.CANCELLED) == 1
    assert what(task)[-1] is TraceEventKind.FINISHED


def test_a_broken_planner_is_no_matter_where_the_goal_holds_already() -> None:
    with Bench(tiny_world(), planner=Breaks(0)) as bench:
        first = begin(bench)
        bench.until(lambda: first.done, limit=1.0)
        held = begin(bench, "In(ball_1, box_a)")
        bench.until(lambda: held.done, limit=1.0)

    assert held.report is not None
    assert held.report.outcome is Outcome.HELD_ALREADY


def test_a_task_that_could_not_begin_leaves_the_one_alone_that_has_its_name_later() -> None:
    with Bench(tiny_world()) as bench:
        bench.cycle.stop_all("somebody hit the button")
        with pytest.raises(UsageError) as refused:
            bench.tasks.begin(bench.goal(GOAL), name="kit 7")
        bench.cycle.reset()
        task = bench.tasks.begin(bench.goal(GOAL), name="kit 7")
        del refused
        gc.collect()
        assert bench.tasks.active == (task,)
