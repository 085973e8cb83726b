"""Tasks that stand, brake or wait for a person, and others that want their robots meanwhile."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import pytest

from skiros_py.behaviours import AssertEffects, Do, P, Sequence, Wait
from skiros_py.devices.mobile_base import Base, BaseTwist
from skiros_py.errors import UsageError
from skiros_py.execution.cycle import Task
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.planners.planner import Answer
from skiros_py.ports.values import Pending
from skiros_py.skills.outcome import Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.policy import Policy
from skiros_py.tasks.report import Outcome as TaskOutcome
from skiros_py.tasks.trace import StepRun, TraceEntry, TraceEventKind
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import DRIVE, PICK, PLACE, pretend

SLOW = tuple(pretend(skill, Sequence.of(Wait(1.0), AssertEffects(0.0))) for skill in (DRIVE, PICK, PLACE))
GIANT = "scene:giant_1 a tiny:Giant ; sk:in scene:box_a ."
UNREACHABLE = "In(giant_1, slot_2)"
ASKING = Policy(ask=True)


def begin(bench: Bench, *goal: str, name: str, policy: Policy | None = None) -> TaskHandle:
    return bench.tasks.begin(bench.goal(*goal), name=name, policy=policy)


def outcome(task: TaskHandle) -> TaskOutcome | None:
    return task.report.outcome if task.report else None


# ------------------------------------------------------------------ paused


def test_a_paused_task_that_waits_for_a_robot_does_not_take_it_and_others_need_not_wait_for_it() -> None:
    with Bench(tiny_world(), SLOW) as bench:
        first = begin(bench, "In(ball_1, slot_1)", name="one")
        second = begin(bench, "In(red_ball_1, slot_2)", name="two")
        bench.until(lambda: second.plan)
        second.pause()
        bench.until(lambda: first.done)
        bench.advance(1.0)
        third = begin(bench, "At(robot_1, box_b)", name="three")
        bench.until(lambda: third.done, limit=5.0)
        second.resume()
        bench.until(lambda: second.done, limit=10.0)

    assert [outcome(task) for task in (first, second, third)] == [TaskOutcome.REACHED] * 3


def test_a_paused_task_keeps_what_it_has() -> None:
    with Bench(tiny_world(), SLOW) as bench:
        first = begin(bench, "In(ball_1, slot_1)", name="one")
        bench.until(lambda: bench.world.related("ball_1", "sk:heldBy", "gripper_1"))
        first.pause()
        second = begin(bench, "At(robot_1, box_b)", name="two")
        bench.advance(10.0)
        assert not second.done
        first.resume()
        bench.until(lambda: first.done and second.done)

    assert (outcome(first), outcome(second)) == (TaskOutcome.REACHED, TaskOutcome.REACHED)


# ------------------------------------------------------------------ waiting for a person


def lying(bench: Bench) -> TaskHandle:
    """Returns a task that asks a person because its pick failed too often."""
    task = begin(bench, "In(ball_1, slot_1)", name="asks", policy=Policy(ask=True, attempts=1))
    bench.until(lambda: task.question is not None)
    return task


def test_a_task_that_waits_for_a_person_lends_the_robot_that_does_nothing() -> None:
    with Bench(tiny_world(), (SLOW[0], pretend(PICK, Wait(0.1)), SLOW[2])) as bench:
        task = lying(bench)
        other = begin(bench, "At(robot_1, box_b)", name="other")
        bench.until(lambda: other.done, limit=5.0)
        assert task.question is not None
        bench.questions.answer(task.question.id, "retry", by="ann")
        bench.until(lambda: task.question is None)
        bench.until(lambda: task.question is not None, limit=10.0)

    assert outcome(other) is TaskOutcome.REACHED
    assert [e.skill for e in task.trace.entries if e.what is TraceEventKind.STARTED] == [
        "drive",
        "pick",
        "drive",
        "pick",
    ]


def test_a_task_that_waits_for_a_person_keeps_a_robot_that_has_its_thing_in_the_hand() -> None:
    with Bench(tiny_world(), (*SLOW[:2], pretend(PLACE, Wait(0.1)))) as bench:
        task = lying(bench)
        assert bench.world.related("ball_1", "sk:heldBy", "gripper_1")
        other = begin(bench, "At(robot_1, box_b)", name="other")
        bench.advance(5.0)
        assert not other.done
        task.stop()
        bench.until(lambda: other.done, limit=5.0)

    assert outcome(other) is TaskOutcome.REACHED


def test_after_the_answer_it_waits_for_its_turn() -> None:
    with Bench(tiny_world(), (SLOW[0], pretend(PICK, Wait(0.1)), SLOW[2])) as bench:
        task = lying(bench)
        other = begin(bench, "At(robot_1, box_b)", name="other")
        bench.until(lambda: "drive" in bench.managers["base_1"].running)
        assert task.question is not None
        bench.questions.answer(task.question.id, "retry", by="ann")
        bench.until(lambda: other.done)
        ended = bench.time
        bench.until(lambda: task.question is not None, limit=10.0)

    later = [e for e in task.trace.entries if e.what is TraceEventKind.STARTED][2:]
    assert [e.skill for e in later] == ["drive", "pick"]
    assert all(e.time >= ended - 1e-9 for e in later)


# ------------------------------------------------------------------ braking


class Roll(Primitive["Roll.Params"]):
    """Rolls: robot 1 for a second, others for a short time."""

    name: ClassVar[str] = "roll"

    @dataclass(frozen=True, slots=True)
    class Params:
        base: str = param("sk:Base", "The base.", kind=Kind.HARDWARE)

    def execute(self) -> Execution[Outcome]:
        end = self.context.now + (1.0 if self.params.base == "base_1" else 0.3)
        while self.context.now < end:
            Base(self.context.board, self.params.base).command(BaseTwist(0.5, 0.0))
            yield
        return Success()


ROLLING = (pretend(DRIVE, Sequence.of(Do.of("roll", base=P("Base")), AssertEffects(0.0))), *SLOW[1:])
BOTH = ("Holding(gripper_1, ball_1)", "Holding(gripper_2, red_ball_1)")


def breaks_at_pick(run: StepRun) -> None:
    if run.step.skill == "pick":
        raise UsageError("the disk is full")


def test_a_task_that_breaks_is_over_when_all_that_it_moved_stands() -> None:
    with Bench(tiny_world(robots=2), ROLLING, (Roll,)) as bench:
        task = begin(bench, *BOTH, name="breaks")
        task.before_step(breaks_at_pick)
        bench.until(lambda: task.done, limit=5.0)

        assert bench.time < 0.9, "robot 1 was stopped on its way"
        assert bench.cycle.board.still
        assert bench.managers["base_1"].running == {}
    assert task.report is not None
    assert task.report.fault == "the disk is full"
    assert [(step.agent, bool(step.reason)) for step in task.report.steps] == [("base_2", False), ("base_1", True)]


def test_a_robot_that_still_brakes_for_a_task_that_is_over_is_nobody_elses_yet(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with Bench(tiny_world(), ROLLING, (Roll,)) as bench:
        ticked: list[Task[Any]] = []
        start = bench.cycle.start
        with monkeypatch.context() as patch:
            patch.setattr(bench.cycle, "start", lambda *args: ticked.append(start(*args)))
            begin(bench, "In(ball_1, slot_1)", name="work")
        (work,) = ticked
        bench.advance(0.5)
        other = begin(bench, "At(robot_1, box_b)", name="other")
        bench.advance(0.1)
        still: list[bool] = []

        def hear(entry: TraceEntry) -> None:
            if entry.what is TraceEventKind.STARTED:
                still.append(bench.cycle.board.still)

        other.trace.subscribe(hear)
        work.stop("enough")
        assert not bench.cycle.board.still
        bench.until(lambda: other.done, limit=5.0)

    assert still == [True]
    assert outcome(other) is TaskOutcome.REACHED


# ------------------------------------------------------------------ planning


class Thinks:
    """An answer that comes when it was looked for a few times."""

    def __init__(self, answer: Pending[Answer]) -> None:
        self._answer = answer
        self._looks = 5

    @property
    def latency(self) -> float:
        return self._answer.latency

    def done(self) -> bool:
        self._looks -= 1
        return self._looks < 0 and self._answer.done()

    def result(self) -> Answer:
        return self._answer.result()

    def cancel(self) -> None:
        self._answer.cancel()


class Thoughtful(FastDownward):
    """Plans, and takes its time."""

    def solve(self, domain: str, problem: str) -> Pending[Answer]:
        return Thinks(super().solve(domain, problem))


@pytest.mark.parametrize("stop_the_other", [False, True])
def test_simulated_time_stands_still_while_a_task_is_planned_though_another_one_is_stopped(
    stop_the_other: bool,
) -> None:
    with Bench(tiny_world(), planner=Thoughtful()) as bench:
        task = begin(bench, "In(ball_1, slot_1)", name="one")
        other = begin(bench, "In(red_ball_1, slot_2)", name="two")
        if stop_the_other:
            other.stop("no more")
        bench.cycle.step()

        assert task.plan is not None
