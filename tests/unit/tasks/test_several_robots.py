"""Steps of several robots, and several tasks at once."""

from __future__ import annotations

import pytest

from skiros_py.behaviours import AssertEffects, Sequence, Wait
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.report import Outcome, StepReport
from skiros_py.tasks.trace import TraceEventKind
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import DRIVE, PICK, PLACE, pretend
from skiros_py.world.change import Change
from skiros_py.world.world import World

SLOW = tuple(pretend(skill, Sequence.of(Wait(1.0), AssertEffects(0.0))) for skill in (DRIVE, PICK, PLACE))
SLOTS = "".join(f'scene:slot_{n} a tiny:Slot ; rdfs:label "slot {n}" ; sk:on scene:floor .\n' for n in (3, 4))
BALLS = "".join(f'scene:ball_{n} a tiny:Ball ; rdfs:label "ball {n}" ; sk:in scene:box_a .\n' for n in (2, 3))
EACH_ITS_OWN = ("Holding(gripper_1, ball_1)", "Holding(gripper_2, red_ball_1)")


def two_robots(*facts: str) -> World:
    return tiny_world(*facts, robots=2)


def finish(bench: Bench, *tasks: TaskHandle, limit: float = 60.0) -> None:
    bench.until(lambda: all(u.done for u in tasks), limit=limit)


def overlapping(steps: tuple[StepReport, ...]) -> bool:
    """Tells whether two steps of different subsystems ran at the same time."""
    return any(a.start < b.end and b.start < a.end for a in steps for b in steps if a.agent < b.agent)


# ------------------------------------------------------------------ one task, two robots


def test_steps_of_two_robots_that_have_nothing_to_do_with_each_other_run_together() -> None:
    with Bench(two_robots(), SLOW) as bench:
        report = bench.pursue(*EACH_ITS_OWN)

    assert report.reached
    assert overlapping(report.steps)
    assert report.simulated < 2.1, "two steps of a second each, twice at the same time"


def test_between_the_steps_of_each_robot_no_cycle_is_idle() -> None:
    with Bench(two_robots(), SLOW) as bench:
        report = bench.pursue(*EACH_ITS_OWN)

    for robot in "12":
        drive, pick = sorted((s for s in report.steps if s.agent.endswith(robot)), key=lambda s: s.start)
        assert pick.start == pytest.approx(drive.end, abs=1e-9), "it starts in the cycle in which the end is seen"


def test_when_one_robots_step_fails_the_other_ones_runs_on() -> None:
    skills = (pretend(DRIVE), *SLOW[1:])
    with Bench(two_robots(), skills) as bench:
        task = bench.tasks.begin(bench.goal(*EACH_ITS_OWN))
        bench.until(lambda: all("pick" in bench.managers[arm].running for arm in ("arm_1", "arm_2")))
        bench.advance(0.5)
        bench.managers["arm_1"].stop()
        finish(bench, task)

    assert task.report is not None
    assert task.report.reached
    picks = [(s.agent, s.reason) for s in task.report.steps if s.skill == "pick"]
    assert picks == [("arm_1", "pick was stopped"), ("arm_2", ""), ("arm_1", "")]


def test_a_change_that_breaks_one_robots_step_leaves_the_other_ones_alone() -> None:
    with Bench(two_robots(), SLOW) as bench:
        task = bench.tasks.begin(bench.goal(*EACH_ITS_OWN))
        bench.until(lambda: all("drive" in bench.managers[base].running for base in ("base_1", "base_2")))
        bench.advance(0.5)
        with bench.world.transaction("somebody", "moved it") as tx:
            tx.place("ball_1", "sk:in", "box_b")
        finish(bench, task)

    report = task.report
    assert report is not None
    assert report.reached
    drives = [(s.agent, s.arguments["Location"], bool(s.reason)) for s in report.steps if s.skill == "drive"]
    assert sorted(drives) == [("base_1", "box_a", True), ("base_1", "box_b", False), ("base_2", "box_b", False)]


def test_running_steps_that_fit_the_new_plan_are_not_cancelled() -> None:
    with Bench(two_robots(BALLS), SLOW) as bench:
        task = bench.tasks.begin(bench.goal("In(Ball, slot_1)"))
        bench.until(lambda: any("drive" in manager.running for manager in bench.managers.values()))
        assert task.plan is not None
        chosen = next(s.arguments["Ball"] for s in task.plan.steps if s.skill == "pick")
        before = task.plan.steps[0]
        bench.advance(0.5)
        with bench.world.transaction("somebody", "took it") as tx:
            tx.place(chosen, "sk:on", "floor")
        finish(bench, task)

    report = task.report
    assert report is not None
    assert report.reached
    if before.arguments["Location"] == "box_a":
        assert [s.skill for s in report.steps] == ["drive", "pick", "place"]


# ------------------------------------------------------------------ several tasks


def test_two_tasks_on_two_robots_run_at_the_same_time() -> None:
    with Bench(two_robots(), SLOW) as bench:
        both = [bench.tasks.begin(bench.goal(one), name=one) for one in EACH_ITS_OWN]
        finish(bench, *both, limit=2.5)

    assert all(u.report is not None and u.report.reached for u in both)


def test_two_tasks_that_want_one_robot_take_turns_and_the_second_says_what_it_waits_for() -> None:
    with Bench(tiny_world(), SLOW) as bench:
        first = bench.tasks.begin(bench.goal("In(ball_1, slot_1)"), name="kit 1")
        second = bench.tasks.begin(bench.goal("In(red_ball_1, slot_2)"), name="kit 2")
        bench.until(lambda: first.done)
        assert second.report is None
        assert bench.tasks.active == (second,)
        finish(bench, second)

    assert [u.report.outcome for u in (first, second) if u.report] == [Outcome.REACHED, Outcome.REACHED]
    assert first.report is not None
    assert second.report is not None
    assert min(s.start for s in second.report.steps) >= max(s.end for s in first.report.steps)
    waits = [e.text for e in second.trace.entries if e.what is TraceEventKind.WAITS]
    assert waits == ["base_1: drive box_b waits: for robot_1 (kit 1)"]


def test_two_tasks_of_any_ball_take_different_ones() -> None:
    with Bench(two_robots(BALLS, SLOTS), SLOW) as bench:
        both = [bench.tasks.begin(bench.goal(f"In(Ball, slot_{n})"), name=f"kit {n}") for n in (1, 2)]
        finish(bench, *both)

        assert all(u.report is not None and u.report.reached for u in both)
        picked = [s.arguments["Ball"] for u in both if u.report for s in u.report.steps if s.skill == "pick"]
        assert len(picked) == len(set(picked)) == 2


def test_a_task_does_not_take_away_what_another_one_that_runs_needs() -> None:
    def in_slot(change: Change) -> None:
        holding.append(bench.world.subjects("sk:in", "slot_1"))

    holding: list[tuple[str, ...]] = []
    with Bench(two_robots(BALLS), SLOW) as bench:
        bench.world.subscribe(in_slot)
        first = bench.tasks.begin(bench.goal("In(ball_1, slot_1)"))
        second = bench.tasks.begin(bench.goal("In(ball_2, slot_1)"))
        finish(bench, first, second)

    assert all(len(balls) <= 1 for balls in holding)
    assert [u.report.reached for u in (first, second) if u.report].count(True) == 1


def test_a_task_that_is_stopped_gives_its_robot_to_who_waits() -> None:
    with Bench(tiny_world(), SLOW) as bench:
        first = bench.tasks.begin(bench.goal("In(ball_1, slot_1)"))
        second = bench.tasks.begin(bench.goal("At(robot_1, box_b)"))
        bench.advance(0.5)
        first.stop()
        finish(bench, second, limit=2.0)

    assert second.report is not None
    assert second.report.reached


def test_three_tasks_that_want_both_robots_all_come_to_their_end() -> None:
    goals: list[tuple[str, ...]] = [
        ("Holding(gripper_1, ball_1)", "Holding(gripper_2, red_ball_1)"),
        ("At(robot_1, box_b)", "At(robot_2, box_a)"),
        ("At(robot_2, box_b)", "At(robot_1, box_a)"),
    ]
    with Bench(two_robots(), SLOW) as bench:
        tasks = [bench.tasks.begin(bench.goal(*goal)) for goal in goals]
        finish(bench, *tasks, limit=20.0)

    assert all(u.report is not None and u.report.reached for u in tasks)


def test_equal_runs_of_two_tasks_are_equal() -> None:
    def run() -> list[object]:
        with Bench(two_robots(BALLS, SLOTS), SLOW) as bench:
            both = [bench.tasks.begin(bench.goal(f"In(Ball, slot_{n})")) for n in (1, 2)]
            finish(bench, *both)
            return [u.report.steps for u in both if u.report]

    assert run() == run()
