"""A task that is rehearsed first: what is ruled out is avoided, and nothing is done where no plan works."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from skiros_py.planning.requests import RuledOut
from skiros_py.skills.conditions import Condition
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.policy import Policy
from skiros_py.tasks.rehearsal import Cancellable, Play, Rehearsal, RehearsedStep, Round, StepState
from skiros_py.tasks.report import Outcome
from skiros_py.tasks.trace import TraceEventKind
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import DRIVE, PICK, PLACE, pretend

GOAL = "In(ball_1, slot_1)"
SKILLS = tuple(map(pretend, (DRIVE, PICK, PLACE)))
FIRST = RuledOut("pick", "arm_1", "ball_1", None, "there is a board above ball_1")


def step(state: StepState, reason: str = "") -> RehearsedStep:
    return RehearsedStep("pick box_a ball_1", "pick", {"Ball": "ball_1"}, state, 1, reason)


def play(*, reached: bool, steps: Sequence[RehearsedStep] = (), ruled_out: Sequence[RuledOut] = ()) -> Play:
    return Play(0, tuple(steps), reached, "" if reached else "it slips", 12.0, tuple(ruled_out))


def rehearsal(*rounds: Round, ruled_out: Sequence[RuledOut] = ()) -> Rehearsal:
    return Rehearsal(rounds, tuple(ruled_out), (), 1.0)


class Done:
    """A rehearsal that ends when it is told to."""

    def __init__(self, result: Rehearsal, *, is_done: bool = True) -> None:
        self._result = result
        self.is_done = is_done
        self.cancelled = False

    def done(self) -> bool:
        return self.is_done

    def result(self) -> Rehearsal:
        return self._result

    def cancel(self) -> None:
        self.cancelled = True


PASSED = rehearsal(Round((play(reached=True),)))


def begin(
    bench: Bench, answer: Cancellable[Rehearsal], *, partial: bool = False
) -> tuple[TaskHandle, list[Sequence[Condition]]]:
    """Begins a task that is to be rehearsed; returns it, and the goals that are asked for."""
    asked: list[Sequence[Condition]] = []

    def rehearse(goal: Sequence[Condition]) -> Cancellable[Rehearsal]:
        asked.append(goal)
        return answer

    object.__setattr__(vars(bench.tasks)["_context"], "rehearser", rehearse)
    return bench.tasks.begin(bench.goal(GOAL), policy=Policy(rehearse=True, partial=partial)), asked


@pytest.mark.parametrize("ruled_out", [(), (FIRST,)])
def test_what_a_rehearsal_ruled_out_is_not_planned(ruled_out: Sequence[RuledOut]) -> None:
    passed = rehearsal(Round((play(reached=True),)), ruled_out=ruled_out)
    with Bench(tiny_world(), SKILLS) as bench:
        task, asked = begin(bench, Done(passed))
        bench.until(lambda: task.done)

    assert [len(goal) for goal in asked] == [1]
    assert task.result.reached is not bool(ruled_out)
    assert FIRST.reason in "".join(task.result.no_plan) or not ruled_out


def test_a_goal_that_would_fail_is_not_begun_and_says_why() -> None:
    with Bench(tiny_world(), SKILLS) as bench:
        task, _ = begin(bench, Done(rehearsal(Round((play(reached=False),)))))
        bench.until(lambda: task.done)

    assert task.result.outcome is Outcome.NO_PLAN
    assert task.result.steps == ()
    assert task.result.no_plan == ("would fail: it slips (in 1 of 1 draws)",)
    assert [e.text for e in task.trace.entries if e.what is TraceEventKind.REHEARSED] == list(task.result.no_plan)


def test_what_can_be_reached_is_begun_if_that_is_the_policy() -> None:
    with Bench(tiny_world(), SKILLS) as bench:
        task, _ = begin(bench, Done(rehearsal(Round((play(reached=False),)))), partial=True)
        bench.until(lambda: task.done)

    assert task.result.reached
    assert task.rehearsal is not None
    assert not task.rehearsal.passed


def test_a_stopped_task_cancels_its_rehearsal() -> None:
    answer = Done(PASSED, is_done=False)
    with Bench(tiny_world(), SKILLS) as bench:
        context = vars(bench.tasks)["_context"]
        object.__setattr__(context, "lockstep", False)
        task, _ = begin(bench, answer)
        bench.until(lambda: any(e.what is TraceEventKind.REHEARSES for e in task.trace.entries))
        task.stop("no longer wanted")
        bench.until(lambda: task.done)

    assert answer.cancelled
    assert task.result.outcome is Outcome.STOPPED


def test_a_goal_that_holds_is_not_rehearsed() -> None:
    with Bench(tiny_world(), SKILLS) as bench:
        task, asked = begin(bench, Done(PASSED))
        bench.until(lambda: task.done)
        again, asked_again = begin(bench, Done(PASSED))
        bench.until(lambda: again.done)

    assert (len(asked), len(asked_again)) == (1, 0)
    assert again.result.outcome is Outcome.HELD_ALREADY


@pytest.mark.parametrize(
    ("rounds", "passed", "first_fails", "seconds"),
    [
        ((Round((play(reached=True, steps=[step(StepState.DONE)]),)),), True, False, 12.0),
        ((Round((play(reached=True, steps=[step(StepState.FAILED, "no")]),)),), True, True, 12.0),
        ((Round((play(reached=False, ruled_out=[FIRST]),)), Round((play(reached=True),))), True, True, 12.0),
        ((Round((play(reached=True), play(reached=False))),), False, True, None),
        ((Round(no_plan=("nothing does it",)),), False, True, None),
    ],
)
def test_a_rehearsal_passed_if_its_last_plan_reached_the_goal_in_each_draw(
    rounds: Sequence[Round], passed: bool, first_fails: bool, seconds: float | None
) -> None:
    result = rehearsal(*rounds)

    assert (result.passed, result.first_fails, result.seconds) == (passed, first_fails, seconds)
    assert bool(result.reason) is not passed
