"""Tasks that are planned while others go on and change the world."""

from __future__ import annotations

import time
from collections.abc import Callable

from skiros_py.behaviours import AssertEffects, Sequence, Wait
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.planners.planner import Answer
from skiros_py.planning.process import ThreadHost
from skiros_py.ports.values import Pending
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.report import Outcome
from skiros_py.tasks.task_manager import TaskManager
from skiros_py.tasks.trace import TraceEventKind
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import DRIVE, PICK, PLACE, pretend

SLOW = tuple(pretend(skill, Sequence.of(Wait(1.0), AssertEffects(0.0))) for skill in (DRIVE, PICK, PLACE))

GIANT_IN_HAND = "scene:giant_1 a tiny:Giant ; sk:heldBy scene:gripper_1 ."
"""It fits into no slot, so the hand never gets free."""


class Withheld:
    """An answer that is there when something has happened, and before that not."""

    def __init__(self, answer: Pending[Answer], shown: Callable[[], bool]) -> None:
        self._answer = answer
        self._shown = shown

    @property
    def latency(self) -> float:
        return self._answer.latency

    def done(self) -> bool:
        while self._shown() and not self._answer.done():
            time.sleep(0.001)  # time of the run stands still
        return self._answer.done() and self._shown()

    def result(self) -> Answer:
        return self._answer.result()

    def cancel(self) -> None:
        self._answer.cancel()


class Withholding(FastDownward):
    """Plans, and shows plans when somebody allows it."""

    def __init__(self) -> None:
        super().__init__()
        self.shown: Callable[[], bool] = lambda: True

    def solve(self, domain: str, problem: str) -> Pending[Answer]:
        able = "(:action" in domain  # where others have all robots, it is asked first what there is without these
        return Withheld(super().solve(domain, problem), self.shown if able else lambda: True)


def not_in_lockstep(bench: Bench, planner: Withholding) -> TaskManager:
    """Returns a task manager for which time goes on while a planner works."""
    bench.cycle.pace = 1000.0
    manager = TaskManager(bench.runtime, ThreadHost(bench.world, planner), "beside others")
    bench.cycle.pace = None
    return manager


def slept() -> bool:
    """Lets the planner have the processor."""
    time.sleep(0.002)
    return True


def outcome(task: TaskHandle) -> Outcome | None:
    return task.report.outcome if task.report else None


def test_a_plan_outdated_by_another_task_is_replanned() -> None:
    planner = Withholding()
    with Bench(tiny_world(), SLOW, planner=planner) as bench:
        tasks = not_in_lockstep(bench, planner)
        one = tasks.begin(bench.goal("In(ball_1, slot_1)"), name="one")
        bench.until(lambda: slept() and bench.world.related("ball_1", "sk:heldBy", "gripper_1"))
        planner.shown = lambda: one.done
        two = tasks.begin(bench.goal("In(red_ball_1, slot_2)"), name="two")
        bench.until(lambda: slept() and one.done and two.done)

    assert (outcome(one), outcome(two)) == (Outcome.REACHED, Outcome.REACHED)


def test_that_there_is_no_plan_is_looked_into_again_where_the_world_has_changed_meanwhile() -> None:
    planner = Withholding()
    with Bench(tiny_world(GIANT_IN_HAND), SLOW, planner=planner) as bench:
        freed: list[float] = []
        planner.shown = lambda: bool(freed)
        task = not_in_lockstep(bench, planner).begin(bench.goal("In(ball_1, slot_1)"), name="one")
        bench.advance(0.5)
        with bench.world.transaction("somebody", "it was in the way") as tx:
            tx.place("giant_1", "sk:in", "box_a")
        freed.append(bench.time)
        bench.until(lambda: slept() and task.done)

    assert outcome(task) is Outcome.REACHED
    assert not [entry for entry in task.trace.entries if entry.what is TraceEventKind.NO_PLAN]
