"""Tasks that are begun, and what people do to them while they are under way."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import pytest

from skiros_py.behaviours import AssertEffects, Sequence, Wait
from skiros_py.errors import FileError, UsageError
from skiros_py.planning.planners.planner import Solved
from skiros_py.skills.outcome import Failure, Outcome
from skiros_py.tasks.context import Mode
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.policy import Policy
from skiros_py.tasks.report import GoalReport
from skiros_py.tasks.report import Outcome as TaskOutcome
from skiros_py.tasks.trace import StepRun, TraceEventKind
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import DRIVE, PICK, PLACE, pretend

GOAL = "In(ball_1, slot_1)"
SLOW = tuple(pretend(skill, Sequence.of(Wait(1.0), AssertEffects(0.0))) for skill in (DRIVE, PICK, PLACE))
STEPS = ["drive", "pick", "place"]


def begin(bench: Bench, *goal: str, policy: Policy | None = None, name: str = "") -> TaskHandle:
    return bench.tasks.begin(bench.goal(*(goal or (GOAL,))), policy=policy, name=name)


def finish(bench: Bench, task: TaskHandle, limit: float = 60.0) -> GoalReport:
    bench.until(lambda: task.done, limit=limit)
    assert task.report is not None
    assert bench.tasks.active == () or task not in bench.tasks.active
    return task.report


def running(bench: Bench, skill: str) -> bool:
    return any(skill in manager.running for manager in bench.managers.values())


def what(task: TaskHandle) -> list[TraceEventKind]:
    return [entry.what for entry in task.trace.entries]


# ------------------------------------------------------------------ beginning


def test_a_task_is_begun_at_once_and_runs_in_the_control_cycle() -> None:
    with Bench(tiny_world()) as bench:
        task = begin(bench, name="kit 7")
        assert (task.status, task.done, task.plan) == ("planning", False, None)
        assert bench.tasks.active == (task,)
        bench.cycle.step()
        assert task.status == "running"
        assert task.plan is not None
        report = finish(bench, task)

    assert report.outcome is TaskOutcome.REACHED
    assert task.status == "ended"
    assert bench.tasks.active == ()


def test_two_tasks_of_one_name_are_not_under_way_together() -> None:
    with Bench(tiny_world()) as bench:
        first = begin(bench, name="kit 7")
        with pytest.raises(UsageError, match="'kit 7' is under way already"):
            begin(bench, name="kit 7")
        finish(bench, first)
        assert finish(bench, begin(bench, name="kit 7")).outcome is TaskOutcome.HELD_ALREADY


def test_nothing_is_begun_while_everything_is_halted() -> None:
    with Bench(tiny_world()) as bench:
        bench.cycle.halt("a hand was seen")
        with pytest.raises(UsageError, match="a hand was seen"):
            begin(bench)
        assert bench.tasks.active == ()


def test_a_goal_that_holds_already_is_over_in_one_cycle_with_no_step() -> None:
    with Bench(tiny_world()) as bench:
        report = finish(bench, begin(bench, "In(ball_1, box_a)"), limit=0.02)

    assert (report.outcome, report.steps) == (TaskOutcome.HELD_ALREADY, ())


def test_a_contradiction_is_answered_before_anything_is_done() -> None:
    with Bench(tiny_world()) as bench:
        report = finish(bench, begin(bench, "In(ball_1, slot_1)", "In(ball_1, slot_2)"))

    assert report.outcome is TaskOutcome.NO_PLAN
    assert report.steps == ()
    assert report.no_plan


def test_of_a_goal_that_cannot_be_reached_as_a_whole_a_part_is_done_where_that_is_wanted() -> None:
    world = tiny_world("scene:giant_1 a tiny:Giant ; sk:in scene:box_a .")
    with Bench(world) as bench:
        report = finish(bench, begin(bench, "In(giant_1, slot_2)", GOAL, policy=Policy(partial=True)))

    giant, ball = report.conditions
    assert report.outcome is TaskOutcome.PARTLY_REACHED
    assert "fits in" in giant.reason
    assert (ball.believed, ball.reason) == (True, "")


@pytest.mark.parametrize("attempts", [0, -1, 1.5, True])
def test_attempts_are_a_whole_number(attempts: object) -> None:
    with pytest.raises(UsageError, match="attempts"):
        Policy(attempts=attempts)  # type: ignore[arg-type]


# ------------------------------------------------------------------ the trace


def test_the_trace_tells_the_whole_story_in_sentences_and_as_data() -> None:
    with Bench(tiny_world()) as bench:
        task = begin(bench, name="kit 7")
        heard: list[str] = []
        task.trace.subscribe(lambda entry: heard.append(entry.text))
        finish(bench, task)

    assert heard == [
        "kit 7: In(ball_1, slot_1)",
        "plan: base_1: drive box_a; arm_1: pick box_a ball_1; arm_1: place ball_1 slot_1",
        "base_1: drive box_a starts",
        "base_1: drive box_a is done",
        "arm_1: pick box_a ball_1 starts",
        "arm_1: pick box_a ball_1 is done",
        "arm_1: place ball_1 slot_1 starts",
        "arm_1: place ball_1 slot_1 is done",
        "kit 7: reached",
    ]
    started = [e for e in task.trace.entries if e.what is TraceEventKind.STARTED]
    assert [(e.step, e.skill, e.agent) for e in started] == [
        (1, "drive", "base_1"),
        (2, "pick", "arm_1"),
        (3, "place", "arm_1"),
    ]
    assert started[1].arguments["Ball"] == "ball_1"


def test_listeners_are_notified_before_the_first_command_of_each_step_and_after_its_end() -> None:
    heard: list[tuple[object, ...]] = []
    with Bench(tiny_world()) as bench:
        task = begin(bench)

        def before(run: StepRun) -> None:
            heard.append(
                ("before", run.number, run.step.skill, [e for e in bench.events if e.module == run.step.skill])
            )

        def after(run: StepRun, outcome: Outcome) -> None:
            heard.append(("after", run.number, run.step.skill, isinstance(outcome, Failure)))

        task.before_step(before)
        task.after_step(after)
        finish(bench, task)

    assert heard == [
        entry
        for n, skill in enumerate(STEPS, start=1)
        for entry in (("before", n, skill, []), ("after", n, skill, False))
    ]


def test_a_step_whose_intent_cannot_be_kept_is_not_started_and_the_task_ends() -> None:
    with Bench(tiny_world()) as bench:
        task = begin(bench)

        def full(run: StepRun) -> None:
            if run.step.skill == "pick":
                raise FileError(Path("jobs"), "the disk is full")

        task.before_step(full)
        report = finish(bench, task)
        assert not any(event.module == "pick" for event in bench.events)

    assert "the disk is full" in report.fault
    assert report.outcome is TaskOutcome.NOT_REACHED
    assert [step.skill for step in report.steps] == ["drive"]


# ------------------------------------------------------------------ pause, resume, step


def test_a_paused_task_stands_and_goes_on_where_it_was() -> None:
    with Bench(tiny_world(), SLOW) as bench:
        task = begin(bench)
        bench.until(lambda: running(bench, "pick"))
        bench.advance(0.5)
        task.pause()
        assert task.status == "paused"
        bench.advance(5.0)
        assert running(bench, "pick")
        task.resume()
        took = bench.until(lambda: not running(bench, "pick"))
        report = finish(bench, task)

    assert report.outcome is TaskOutcome.REACHED
    assert took < 1.0, "half of it was done before"
    assert [step.skill for step in report.steps] == STEPS
    assert [w for w in what(task) if w in (TraceEventKind.PAUSED, TraceEventKind.RESUMED)] == [
        TraceEventKind.PAUSED,
        TraceEventKind.RESUMED,
    ]


def test_while_it_is_paused_no_step_starts_and_nothing_is_cancelled() -> None:
    with Bench(tiny_world(), SLOW) as bench:
        task = begin(bench)
        bench.until(lambda: running(bench, "drive"))
        task.pause()
        with bench.world.transaction("somebody", "moved it") as tx:
            tx.place("ball_1", "sk:in", "box_b")
        bench.advance(3.0)
        assert running(bench, "drive")
        assert task.plan is not None
        assert task.plan.steps[0].arguments["Location"] == "box_a"
        task.resume()
        report = finish(bench, task)

    assert report.outcome is TaskOutcome.REACHED
    assert report.steps[0].reason.startswith("the plan no longer leads to the goal")


def test_a_task_that_was_paused_before_it_began_plans_and_waits() -> None:
    with Bench(tiny_world()) as bench:
        task = begin(bench)
        task.pause()
        bench.advance(0.5)
        assert not bench.events
        task.resume()
        assert finish(bench, task).reached


def test_each_step_request_executes_one_step_and_pauses_again() -> None:
    with Bench(tiny_world()) as bench:
        task = begin(bench)
        task.pause()
        for number in range(1, 4):
            bench.advance(0.2)
            task.step()
            bench.until(lambda: task.control.mode is Mode.PAUSE or task.done, limit=1.0)
            assert len(bench.tasks.steps) == number
        assert finish(bench, task).reached


def test_a_step_request_during_a_step_ends_that_step_and_pauses() -> None:
    with Bench(tiny_world(), SLOW) as bench:
        task = begin(bench)
        bench.until(lambda: running(bench, "drive"))
        task.step()
        bench.advance(3.0)

        assert [step.skill for step in bench.tasks.steps] == ["drive"]
        assert task.status == "paused"


# ------------------------------------------------------------------ stop at every moment


@pytest.mark.parametrize("seconds", [0.0, 0.005, 0.5, 1.0, 1.005, 1.5, 2.0, 2.5, 2.99])
def test_a_task_can_be_stopped_at_any_moment_and_then_nothing_of_it_runs(seconds: float) -> None:
    with Bench(tiny_world(), SLOW) as bench:
        task = begin(bench)
        bench.advance(seconds)
        task.stop("lunch")
        report = finish(bench, task, limit=0.1)

        assert all(not manager.running for manager in bench.managers.values())
        with bench.managers.claims.request("the test", ["arm_1", "gripper_1", "base_1"]) as claim:
            assert claim.granted
        assert (report.outcome, report.stopped) == (TaskOutcome.STOPPED, True)
        assert finish(bench, begin(bench)).reached, "and afterwards everything can be used"


def test_a_second_stop_changes_nothing() -> None:
    with Bench(tiny_world(), SLOW) as bench:
        task = begin(bench)
        bench.until(lambda: running(bench, "pick"))
        task.stop("lunch")
        task.stop("really")
        report = finish(bench, task)
        task.stop("still")
        bench.advance(0.1)

    assert task.report is report
    assert [e.text for e in task.trace.entries if e.what is TraceEventKind.STOPPED] == ["is stopped: lunch"]


def test_a_stop_at_the_moment_of_completion_does_not_undo_what_is_reached() -> None:
    with Bench(tiny_world(), SLOW) as bench:
        task = begin(bench)
        bench.until(lambda: bench.world.related("ball_1", "sk:in", "slot_1"))
        task.stop("too late")
        report = finish(bench, task, limit=0.1)

    assert report.outcome is TaskOutcome.REACHED
    assert not report.stopped


def test_a_stop_after_the_end_is_nothing() -> None:
    with Bench(tiny_world()) as bench:
        task = begin(bench)
        report = finish(bench, task)
        task.stop()
        bench.advance(0.1)

        assert task.report is report
        assert report.reached


def test_a_paused_task_can_be_stopped() -> None:
    with Bench(tiny_world(), SLOW) as bench:
        task = begin(bench)
        bench.until(lambda: running(bench, "pick"))
        task.pause()
        bench.advance(1.0)
        task.stop()
        assert finish(bench, task, limit=0.1).stopped


class SlowPlanner:
    """A planner that works for so long as nobody closes it."""

    name = "slow"
    supports = frozenset({":strips", ":typing"})

    def __init__(self) -> None:
        self.asked = threading.Event()

    def solve(self, domain: str, problem: str) -> SlowPlanner:
        self.asked.set()
        return self

    latency = 0.0

    def done(self) -> bool:
        return False

    def result(self) -> Solved:
        time.sleep(60.0)
        raise AssertionError("nobody waits for ever")

    def cancel(self) -> None:
        pass

    def close(self) -> None:
        pass


def test_a_task_can_be_stopped_while_it_is_planned() -> None:
    planner = SlowPlanner()
    with Bench(tiny_world(), planner=planner) as bench:
        task = begin(bench)
        stopper = threading.Thread(target=lambda: (planner.asked.wait(10.0), task.stop("lunch")))
        stopper.start()
        report = finish(bench, task)
        stopper.join()

    assert report.outcome is TaskOutcome.STOPPED
    assert report.steps == ()


def test_when_everything_is_halted_the_task_is_over_and_says_why() -> None:
    with Bench(tiny_world(), SLOW) as bench:
        task = begin(bench)
        bench.until(lambda: running(bench, "pick"))
        bench.cycle.stop_all("a hand was seen")

    assert task.done
    assert task.report is not None
    assert task.report.fault == "a hand was seen"
    assert not task.report.stopped
    assert task.report.conditions[0].reason == "a hand was seen"
