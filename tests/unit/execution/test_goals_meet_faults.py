"""What the task manager makes of managers that go, of modules that hang, break and are halted: always a report."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import pytest

from skiros_py.behaviours import AssertEffects, Do, Sequence
from skiros_py.catalogue import Catalogue
from skiros_py.errors import PlanningError, UsageError
from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.planning.plan import Plan
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.skills.conditions import Computed, ConditionType, Role, Verdict
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill
from skiros_py.station.session import Options, Session
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.report import GoalReport
from skiros_py.testing import CONDITIONS, TINY_ONTOLOGY, Bench, tiny_scene, tiny_world
from skiros_py.testing.tiny import DRIVE, PICK, PLACE, pretend

GOAL = "In(ball_1, slot_1)"


class Linger(Primitive["Linger.Params"]):
    """Takes its time, and then does what the test says."""

    name: ClassVar[str] = "linger"
    does: ClassVar[list[Callable[[], None]]] = []

    @dataclass(frozen=True, slots=True)
    class Params:
        seconds: float = param("number", "How long.", kind=Kind.OFFLINE, default=0.1, unit="s")

    def execute(self) -> Execution[Outcome]:
        end = self.context.now + self.params.seconds
        while self.context.now < end:
            yield
        if self.does:
            self.does.pop()()
        return Success()


LINGERING = (
    pretend(DRIVE),
    pretend(PICK, Sequence.of(Do.of("linger"), AssertEffects(0.02))),
    pretend(PLACE),
)


@pytest.fixture(autouse=True)
def _fresh() -> None:
    Linger.does.clear()


def during_pick(bench: Bench, action: Callable[[], None]) -> None:
    """Has something happen when the first pick has begun."""
    happened: list[ModuleEvent] = []

    def listen(event: ModuleEvent) -> None:
        if event.module == "linger" and event.status is Status.STARTED and not happened:
            happened.append(event)
            Linger.does.append(action)

    bench.monitor.subscribe(listen)


def pursue(bench: Bench, limit: float = 60.0) -> GoalReport:
    """Pursues the goal; that it hangs is a failure."""
    task = bench.tasks.begin(bench.goal(GOAL))
    bench.until(lambda: task.done, limit=limit)
    return task.result


# ------------------------------------------------------------------ managers that go


@pytest.mark.parametrize(
    "goes",
    [
        lambda bench: bench.managers.close("arm_1"),
        lambda bench: bench.managers["arm_1"].lose("its host is gone"),
    ],
    ids=["closed", "lost"],
)
def test_a_goal_ends_with_a_report_when_the_only_capable_manager_is_removed(goes: Callable[[Bench], None]) -> None:
    with Bench(tiny_world(), LINGERING, (Linger,)) as bench:
        during_pick(bench, lambda: goes(bench))
        report = pursue(bench)

    assert not report.reached
    assert report.conditions[0].reason
    assert [step.skill for step in report.steps][:2] == ["drive", "pick"]


@pytest.mark.parametrize(
    "goes",
    [
        lambda bench, arm: bench.managers.close(arm),
        lambda bench, arm: bench.managers[arm].lose("its host is gone"),
    ],
    ids=["closed", "lost"],
)
def test_another_manager_takes_over_when_one_is_removed(goes: Callable[[Bench, str], None]) -> None:
    with Bench(tiny_world(robots=2), LINGERING, (Linger,)) as bench:
        chosen: list[str] = []

        def leave() -> None:
            chosen.append(next(e.agent for e in reversed(bench.events) if e.module == "pick"))
            goes(bench, chosen[0])
            running = [m for m in bench.managers.values() if m.running]
            for manager in running:
                manager.stop()

        during_pick(bench, leave)
        report = pursue(bench)

    assert report.reached, report
    assert report.steps[-1].arguments["Arm"] != chosen[0]


def test_a_manager_may_be_removed_between_planning_and_execution() -> None:
    with Bench(tiny_world(robots=2), LINGERING, (Linger,)) as bench:
        gone: list[str] = []

        def leave(event: ModuleEvent) -> None:
            if event.module == "drive" and event.status is Status.TERMINATED and not gone:
                gone.append(f"arm_{event.agent[-1]}")
                bench.managers.close(gone[0])

        bench.monitor.subscribe(leave)
        report = pursue(bench)

    assert report.reached, report
    assert report.steps[-1].arguments["Arm"] != gone[0]


def test_a_manager_added_while_a_goal_is_pursued_is_used_in_planning() -> None:
    with Bench(tiny_world(robots=2), LINGERING, (Linger,)) as bench:
        for arm in ("arm_1", "arm_2"):
            bench.managers.close(arm)
        bench.managers.open("arm_1")

        def replace_it() -> None:
            bench.managers.close("arm_1")
            bench.managers.open("arm_2")

        during_pick(bench, replace_it)
        report = pursue(bench)

    assert report.reached, report
    assert report.steps[-1].arguments["Arm"] == "arm_2"


def test_planning_with_a_skill_that_is_no_longer_offered_is_refused_with_reasons() -> None:
    with Bench(tiny_world()) as bench:
        bench.managers.close("arm_1")
        report = bench.pursue(GOAL)

    assert not report.reached
    assert report.no_plan


def test_a_step_waits_for_a_module_that_is_already_running() -> None:
    with Bench(tiny_world("scene:ball_2 a tiny:Ball ; sk:in scene:box_b ."), LINGERING, (Linger,)) as bench:
        bench.run("drive", Location="box_a")
        by_hand = bench.start("pick", Ball="ball_1", Box="box_a")
        report = pursue(bench)

        assert by_hand.done
    assert report.reached, report


# ------------------------------------------------------------------ modules that hang


def test_a_step_stopped_from_outside_counts_as_failed_and_is_retried() -> None:
    with Bench(tiny_world(), LINGERING, (Linger,)) as bench:
        during_pick(bench, lambda: bench.managers["arm_1"].stop())
        report = pursue(bench)

    assert report.reached
    assert [step.reason for step in report.steps if step.skill == "pick"] == ["pick was stopped", ""]


def test_halting_everything_ends_the_goal_and_what_it_runs() -> None:
    with Bench(tiny_world(), LINGERING, (Linger,)) as bench:
        task = bench.tasks.begin(bench.goal(GOAL))
        bench.until(lambda: any(e.module == "linger" for e in bench.events))
        assert bench.cycle.stop_all("somebody is in the way")

        assert task.done
        assert not bench.managers["arm_1"].running
        bench.cycle.reset()
        assert pursue(bench).reached


def _hang() -> None:
    end = time.monotonic() + 30.0
    while time.monotonic() < end:
        pass


def test_when_a_module_blocks_the_cycle_each_running_module_reports_its_end_exactly_once() -> None:
    with Bench(tiny_world(), LINGERING, (Linger,), overrun=0.3) as bench:
        bench.run("drive", Location="box_a")
        other = bench.managers["base_1"].start("linger", {"seconds": 9.0})
        bench.advance(0.01)
        Linger.does.append(_hang)
        running = bench.start("pick", Ball="ball_1", Box="box_a")
        bench.until(lambda: running.done and other.done, limit=1.0)
        ends = [(e.agent, e.module, e.status) for e in bench.events if e.status not in (Status.STARTED, Status.RUNNING)]

        assert sorted(ends[1:], key=str) == [
            ("arm_1", "linger", Status.ERROR),
            ("arm_1", "pick", Status.ERROR),
            ("base_1", "linger", Status.PREEMPTED),
        ]
        assert isinstance(running.result, Failure)
        assert "linger (of pick of arm_1) held the control cycle" in running.result.reason
        assert "held the control cycle" in str(other.result)
        assert bench.managers.claims.request("the test", ["arm_1", "gripper_1"]).granted


# ------------------------------------------------------------------ conditions that break or hang


def picky(does: Callable[[], None]) -> Skill:
    """Returns a pick with a precondition that somebody wrote in Python."""

    def fits(_view: Any, _ball: str, _gripper: str) -> Verdict:
        does()
        return Verdict(True, "it fits")

    roles = (Role("ball", "tiny:Ball"), Role("gripper", "sk:Gripper"))
    type_ = ConditionType("Fits2", roles, Computed("tiny:fitsIn", "ball", "gripper", fits), "Fits.")
    return pretend(replace(PICK, pre=(*PICK.pre, type_("Ball", "Gripper"))))


def _break() -> None:
    raise SystemExit(3)


def test_a_condition_that_raises_during_replay_is_only_a_flaw_of_the_plan() -> None:
    breaks: list[bool] = []
    with Bench(tiny_world(), (pretend(DRIVE), picky(lambda: _break() if breaks else None))) as bench:
        bench.monitor.subscribe(lambda _event: breaks.append(True))
        report = bench.pursue("Holding(gripper_1, ball_1)")

    assert [step.skill for step in report.steps] == ["drive"]
    assert not report.reached
    assert "Fits2" in report.conditions[0].reason


def test_a_condition_that_raises_during_planning_is_a_planning_fault_that_names_it() -> None:
    with Bench(tiny_world(), (pretend(DRIVE), picky(_break))) as bench:
        with pytest.raises(PlanningError, match="Fits2"):
            bench.plan("Holding(gripper_1, ball_1)")
        panel = bench.managers["arm_1"].panel("pick", {})

    assert not panel.ready
    assert "sys.exit(3)" in str(panel.as_json())


def test_a_condition_that_hangs_during_a_plan_check_does_not_delay_a_stop() -> None:
    hangs: list[bool] = []
    checked: list[float] = []

    def fits() -> None:
        if hangs and not checked:
            checked.append(time.monotonic())
            threading.Timer(0.1, lambda: bench.cycle.halt("somebody is in the way")).start()
            _hang()

    with Bench(tiny_world(), (pretend(DRIVE), picky(fits)), overrun=5.0) as bench:
        bench.monitor.subscribe(lambda _event: hangs.append(True))
        report = bench.pursue("Holding(gripper_1, ball_1)")

    assert not report.reached
    assert time.monotonic() - checked[0] < 15.0  # the bench is closed: what hung was interrupted


def test_planning_may_take_longer_than_a_tick() -> None:
    with Bench(tiny_world(), (pretend(DRIVE), picky(lambda: time.sleep(0.3))), overrun=0.2) as bench:
        assert isinstance(bench.plan("Holding(gripper_1, ball_1)").outcome, Plan)
        assert bench.cycle.halted == ""


def test_no_cycle_is_idle_between_two_steps_of_a_plan() -> None:
    with Bench(tiny_world()) as bench:
        bench.pursue("In(ball_1, slot_1)")
        cycles = [(round(e.time / bench.cycle.board.period), e.status) for e in bench.events if e.kind == "skill"]

    ends = [at for at, status in cycles if status is Status.TERMINATED]
    starts = [at for at, status in cycles if status is Status.STARTED]
    assert starts[1:] == [at + 1 for at in ends[:-1]]


# ------------------------------------------------------------------ whole sessions


def catalogue(*skills: Any) -> Catalogue:
    named = {skill.description.name: skill for skill in skills}
    return Catalogue(named, {"linger": Linger}, CONDITIONS, {"fast-downward": FastDownward}, {})


@pytest.fixture
def session(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.setenv("SKIROS_ONTOLOGIES", str(TINY_ONTOLOGY))
    with Session(str(tiny_scene(tmp_path)), Options(fake=True), catalogue=catalogue(*LINGERING)) as made:
        yield made


def test_after_a_halt_by_the_watchdog_a_session_continues_only_after_a_reset(
    session: Session,
) -> None:
    usual = session.runtime.watchdog.limit

    def hang() -> None:
        session.runtime.watchdog.limit = 0.5  # from now on: on a busy machine, healthy ticks may take that long
        _hang()

    Linger.does.append(hang)
    report = session.run(GOAL)
    session.runtime.watchdog.limit = usual

    assert not report.reached
    assert "linger (of pick of arm_1) held the control cycle for" in report.conditions[0].reason
    assert not report.stopped
    with pytest.raises(UsageError, match=r"(?s)nothing can start: everything was halted \(linger.*reset"):
        session.run(GOAL)
    session.reset()
    assert session.run(GOAL).reached


def test_after_a_halt_by_a_module_nothing_starts_before_a_reset(session: Session) -> None:
    Linger.does.append(lambda: session.cycle.halt("a hand was seen"))
    report = session.run(GOAL)

    assert report.conditions[0].reason == "a hand was seen"
    assert not report.stopped
    for start in (session.run_module, session.start_module):
        with pytest.raises(UsageError, match="a hand was seen"):
            start("linger", {})
    session.reset()
    assert session.run(GOAL).reached


def test_a_halt_by_a_single_module_run_stays_until_a_reset(session: Session) -> None:
    Linger.does.append(lambda: session.cycle.halt("a hand was seen"))
    outcome = session.run_module("linger", {})

    assert isinstance(outcome, Success | Failure)
    assert session.cycle.halted == "a hand was seen"
    with pytest.raises(UsageError, match="a hand was seen"):
        session.run_module("linger", {})


def test_after_a_stop_by_the_user_the_next_run_needs_no_reset(session: Session) -> None:
    Linger.does.append(session.stop)
    assert session.run(GOAL).stopped
    assert session.cycle.halted == ""
    assert session.run(GOAL).reached

    Linger.does.append(session.stop)
    session.run_module("linger", {})
    assert session.run_module("linger", {}) == Success()


def test_each_run_notifies_task_listeners_even_if_it_is_stopped(session: Session) -> None:
    begun: list[TaskHandle] = []
    session.tasks.on_begin(begun.append)
    Linger.does.append(session.stop)
    report = session.run(GOAL)
    task = session.begin(GOAL)
    session.runtime.finish(task)

    assert report.stopped
    assert (report.fault, report.conditions[0].reason) == ("", "stopped")
    assert [one.name for one in begun] == ["task 1", "task 2"]
    assert begun[1] is task
    assert task.result.reached


def test_a_task_exception_is_raised_by_run_and_by_the_result_of_the_task(
    session: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    def breaks(*_: object) -> None:
        raise PlanningError("the planner is gone")

    monkeypatch.setattr(session.planning, "ask", breaks)
    task = session.begin(GOAL)
    session.runtime.finish(task)

    for result in (lambda: task.result, lambda: session.run(GOAL)):
        with pytest.raises(PlanningError, match="the planner is gone"):
            result()


def test_a_reset_of_a_running_session_changes_nothing(session: Session) -> None:
    session.reset()

    assert session.run(GOAL).reached


def test_a_manager_that_is_lost_in_a_session_ends_the_goal_with_a_report_and_the_world_stays_usable(
    session: Session,
) -> None:
    Linger.does.append(lambda: session.managers["arm_1"].lose("its host is gone"))
    report = session.run(GOAL)

    assert not report.reached
    assert report.conditions[0].reason
    with session.world.transaction("test", "a person brought it") as tx:
        tx.place("robot_1", "sk:at", "box_b")
    assert session.run("At(robot_1, box_a)").reached
    session.managers.open("arm_1")
    assert session.run(GOAL).reached


def test_a_module_that_raises_in_a_session_is_a_failed_attempt(session: Session) -> None:
    def breaks() -> None:
        raise SystemExit(4)

    Linger.does.append(breaks)
    report = session.run(GOAL)

    assert report.reached
    assert report.conditions[0].tries == 2
    assert "sys.exit(4)" in next(step.reason for step in report.steps if step.reason)
