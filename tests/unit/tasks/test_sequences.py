from __future__ import annotations

import time
from dataclasses import replace

import pytest

from skiros_py.behaviours import AssertEffects, Sequence, Wait
from skiros_py.errors import UsageError
from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.process import ThreadHost
from skiros_py.skills.conditions import Computed, ConditionType, Role, Verdict
from skiros_py.skills.outcome import Success
from skiros_py.tasks.context import TaskContext
from skiros_py.tasks.record import TaskRecord
from skiros_py.tasks.report import Outcome
from skiros_py.tasks.sequences import check_steps
from skiros_py.tasks.task_manager import TaskManager
from skiros_py.tasks.trace import StepEnd, StepRun
from skiros_py.testing import Bench, GivenPlanner, tiny_world
from skiros_py.testing.tiny import DRIVE, PICK, PLACE, pretend
from skiros_py.world.view import WorldView
from skiros_py.world.world import World

SKILLS = {skill.name: skill for skill in (DRIVE, PICK, PLACE)}
DRIVING = {"Base": "base_1", "Robot": "robot_1", "Location": "box_a"}
HAND = {"Arm": "arm_1", "Gripper": "gripper_1", "Robot": "robot_1"}


DRIVE_STEP = Step("drive", DRIVING)
PICK_STEP = Step("pick", {**HAND, "Box": "box_a", "Ball": "ball_1"})
PLACE_STEP = Step("place", {**HAND, "Ball": "ball_1", "Slot": "slot_1"})
STEPS = (DRIVE_STEP, PICK_STEP, PLACE_STEP)


def problems(world: World, *steps: Step) -> list[tuple[str, ...]]:
    return [check.problems for check in check_steps(world, steps, SKILLS)]


# ------------------------------------------------------------------ checks


def test_steps_are_checked_in_the_world_that_the_steps_before_them_leave() -> None:
    alone = "robot_1 is not at box_a: it is at unknown_location"

    assert problems(tiny_world(), PICK_STEP) == [(alone,)]
    assert problems(tiny_world(), *STEPS) == [(), (), ()]
    assert problems(tiny_world(), PICK_STEP, PLACE_STEP, DRIVE_STEP) == [(alone,), (), ()]


def test_a_missing_step_breaks_what_needs_it_and_only_that() -> None:
    assert problems(tiny_world(), DRIVE_STEP, PLACE_STEP) == [
        (),
        ("ball_1 is not heldBy gripper_1: it is in box_a",),
    ]


def test_a_check_is_of_the_world_as_it_is_now() -> None:
    world = tiny_world()
    with world.transaction("somebody", "moved it") as tx:
        tx.place("ball_1", "sk:in", "box_b")

    assert problems(world, *STEPS)[1] == ("ball_1 is not in box_a: it is in box_b",)


@pytest.mark.parametrize(
    ("step", "says"),
    [
        (Step("fly", {}), "unknown skill 'fly'"),
        (Step("drive", {"Wings": "base_1"}), "Wings"),
        (Step("drive", {"Base": "base_7"}), "base_7"),
        (Step("drive", {"Base": "box_a"}), "box_a"),
    ],
)
def test_a_step_that_names_what_is_not_there_is_refused_and_the_others_are_checked_without_it(
    step: Step, says: str
) -> None:
    wrong, *others = check_steps(tiny_world(), (step, *STEPS), SKILLS)

    assert not wrong.is_known
    assert says in wrong.problems[0]
    assert [check.problems for check in others] == [(), (), ()]
    with Bench(tiny_world()) as bench, pytest.raises(UsageError) as refusal:
        bench.tasks.execute((step,), anyway=True)
    assert says in str(refusal.value)


# ------------------------------------------------------------------ running


def test_a_plan_can_be_edited_and_run() -> None:
    with Bench(tiny_world()) as bench:
        plan = bench.plan("In(ball_1, slot_1)").outcome
        assert isinstance(plan, Plan)
        drive, pick, place = plan.steps
        task = bench.tasks.execute((drive, pick, Step(place.skill, {**place.arguments, "Slot": "slot_2"})))
        bench.until(lambda: task.done)

        assert bench.world.related("ball_1", "sk:in", "slot_2")
    assert task.report is not None
    assert task.report.outcome is Outcome.REACHED
    assert [step.skill for step in task.report.steps] == ["drive", "pick", "place"]


def test_steps_that_cannot_work_are_not_begun_and_the_step_and_the_reason_are_reported() -> None:
    with Bench(tiny_world()) as bench:
        assert [check.problems for check in bench.tasks.check((PICK_STEP, PLACE_STEP))][1] == ()
        task = bench.tasks.execute((PICK_STEP, PLACE_STEP))
        bench.until(lambda: task.done)

    assert task.report is not None
    assert task.report.steps == ()
    assert task.report.fault == (
        "round 1 cannot work: pick box_a ball_1: robot_1 is not at box_a: it is at unknown_location"
    )


def test_a_sequence_that_cannot_work_can_be_forced_and_fails_at_the_bad_step() -> None:
    with Bench(tiny_world()) as bench:
        task = bench.tasks.execute((PICK_STEP, PLACE_STEP), anyway=True)
        bench.until(lambda: task.done)

    report = task.report
    assert report is not None
    assert not report.reached
    assert report.fault.startswith("arm_1: pick box_a ball_1 failed 3 times: precondition At(robot_1, box_a)")
    assert [step.skill for step in report.steps] == ["pick"] * 3


def test_a_sequence_is_repeated_so_often_as_wanted() -> None:
    with Bench(tiny_world()) as bench:
        made = (
            Step("drive", {"Base": "base_1", "Robot": "robot_1", "Location": "box_a"}),
            Step("drive", {"Base": "base_1", "Robot": "robot_1", "Location": "box_b"}),
        )
        task = bench.tasks.execute(made, iterate=3)
        bench.until(lambda: task.done)

    assert task.report is not None
    assert [step.arguments["Location"] for step in task.report.steps] == ["box_a", "box_b"] * 3


def test_a_sequence_is_repeated_until_it_is_stopped() -> None:
    with Bench(tiny_world(), (pretend(DRIVE, Sequence.of(Wait(0.2), AssertEffects(0.0))),)) as bench:
        made = (Step("drive", {"Base": "base_1", "Robot": "robot_1", "Location": "box_a"}),)
        task = bench.tasks.execute(made, iterate=None)
        bench.advance(3.0)
        assert not task.done
        task.stop("enough")
        bench.until(lambda: task.done, limit=0.1)

    report = task.report
    assert report is not None
    assert report.outcome is Outcome.STOPPED
    assert len(report.steps) > 10


def test_a_second_round_that_cannot_work_is_not_begun() -> None:
    with Bench(tiny_world()) as bench:
        task = bench.tasks.execute(STEPS, iterate=2)
        bench.until(lambda: task.done)

    report = task.report
    assert report is not None
    assert len(report.steps) == 3
    assert report.fault == "round 2 cannot work: pick box_a ball_1: ball_1 is not in box_a: it is in slot_1"


@pytest.mark.parametrize("iterate", [1, None])
def test_a_sequence_without_steps_is_refused_even_where_it_shall_run_anyway(iterate: int | None) -> None:
    with Bench(tiny_world()) as bench, pytest.raises(UsageError, match="no steps"):
        bench.tasks.execute((), iterate=iterate, anyway=True)


def _slowly(_view: WorldView, robot: str, place: str) -> Verdict:
    time.sleep(0.006)  # as long as the check of a pick takes with an ontology of full size
    return Verdict(True, f"{robot} thinks long about {place}")


_PONDERED = ConditionType(
    "Pondered",
    (Role("robot", "sk:Robot"), Role("place", "sk:Location")),
    Computed("tiny:pondered", "robot", "place", _slowly),
    "-",
)
_PONDERING = pretend(replace(DRIVE, pre=(*DRIVE.pre, _PONDERED("Robot", "Location"))))


def test_the_cycle_goes_on_while_many_steps_are_checked() -> None:
    with Bench(tiny_world(), (_PONDERING,)) as bench:
        bench.cycle.pace = 1000.0
        task = _not_in_lockstep(bench).execute(_drives(30), anyway=True)
        begun = bench.cycle.board.snapshot.cycle
        bench.until(lambda: bench.events, limit=1e5)
        assert bench.cycle.board.snapshot.cycle - begun >= 30
        bench.until(lambda: task.done, limit=1e5)

    assert task.report is not None
    assert len(task.report.steps) == 30


def test_a_sequence_is_stopped_while_its_steps_are_checked() -> None:
    with Bench(tiny_world(), (_PONDERING,)) as bench:
        bench.cycle.pace = 1000.0
        task = _not_in_lockstep(bench).execute(_drives(30), anyway=True)
        bench.cycle.step()
        task.stop("enough")
        bench.cycle.step()
        bench.cycle.step()

    assert task.report is not None
    assert task.report.outcome is Outcome.STOPPED
    assert bench.events == []


def _not_in_lockstep(bench: Bench) -> TaskManager:
    planning = ThreadHost(bench.world, GivenPlanner())
    return TaskManager(bench.runtime, planning, "unhurried")


def _drives(count: int) -> tuple[Step, ...]:
    return tuple(Step("drive", {**DRIVING, "Location": ("box_a", "box_b")[number % 2]}) for number in range(count))


@pytest.mark.parametrize("often", [0, -1, 1.5, True, "2"])
def test_how_often_is_a_whole_number(often: object) -> None:
    with Bench(tiny_world()) as bench, pytest.raises(UsageError, match="iterate"):
        bench.tasks.execute(STEPS, iterate=often)  # type: ignore[arg-type]


def test_a_skill_that_goes_away_is_a_problem_of_its_step() -> None:
    with Bench(tiny_world()) as bench:
        task = bench.tasks.execute(STEPS)
        bench.managers.close("arm_1")
        bench.until(lambda: task.done)

    assert task.report is not None
    assert "pick" in task.report.fault
    assert bench.tasks.check((PICK_STEP,))[0].problems[0].startswith("unknown skill 'pick'")


# ------------------------------------------------------------------ what is left out


def test_omitted_arguments_of_a_step_are_inferred_for_its_check_too() -> None:
    place = Step("place", {"Ball": "ball_1", "Slot": "slot_1"})

    (alone,) = check_steps(tiny_world(), (place,), SKILLS)
    assert alone.agent == "arm_1"
    assert "ball_1 is not heldBy gripper_1: it is in box_a" in alone.problems
    before = Step("drive", {"Location": "box_a"}), Step("pick", {"Ball": "ball_1"})
    assert problems(tiny_world(), *before, place) == [(), (), ()]


def test_a_sequence_that_leaves_nearly_everything_out_is_run() -> None:
    with Bench(tiny_world()) as bench:
        made = (
            Step("drive", {"Location": "box_a"}),
            Step("pick", {"Ball": "ball_1"}),
            Step("place", {"Slot": "slot_2"}),
        )
        task = bench.tasks.execute(made)
        bench.until(lambda: task.done)

        assert bench.world.related("ball_1", "sk:in", "slot_2")
    assert task.report is not None
    assert task.report.reached, task.report.fault


def test_an_omitted_agent_is_the_robot_that_drove_to_the_place() -> None:
    with Bench(tiny_world(robots=2)) as bench:
        made = (Step("drive", {"Base": "base_2", "Location": "box_a"}), Step("pick", {"Ball": "ball_1"}))
        task = bench.tasks.execute(made)
        bench.until(lambda: task.done)

        assert bench.world.related("ball_1", "sk:heldBy", "gripper_2"), str(task.trace)


def test_a_step_without_an_agent_is_done_by_somebody_who_is_there() -> None:
    with Bench(tiny_world(robots=2)) as bench:
        bench.managers.close("base_1")
        made = (Step("drive", {"Location": "box_a"}),)
        task = bench.tasks.execute(made)
        bench.until(lambda: task.done)

    assert task.report is not None
    assert [(step.agent, step.reason) for step in task.report.steps] == [("base_2", "")]


def test_a_step_that_nobody_who_is_there_can_do_ends_the_sequence_before_it_begins() -> None:
    with Bench(tiny_world()) as bench:
        made = (Step("drive", {"Location": "box_a"}),)
        task = bench.tasks.execute(made, anyway=True)
        bench.managers.close("base_1")
        bench.until(lambda: task.done)

    assert task.report is not None
    assert task.report.fault == "round 1 cannot work: drive box_a: no subsystem has the skill drive any more"
    assert task.report.steps == ()


def test_a_step_whose_target_is_left_open_and_that_fails_is_tried_again_and_given_up() -> None:
    with Bench(tiny_world(), (pretend(DRIVE), pretend(PICK, Wait(0.1)))) as bench:
        made = (Step("drive", {"Location": "box_a"}), Step("pick", {"Box": "box_a"}))
        task = bench.tasks.execute(made)
        bench.until(lambda: task.done)

    assert task.report is not None
    assert "pick box_a failed 3 times" in task.report.fault


def test_a_sequence_that_runs_for_ever_keeps_its_last_steps_and_counts_the_others() -> None:
    with Bench(tiny_world()) as bench:
        context = TaskContext(bench.world, bench.managers, ThreadHost(bench.world, GivenPlanner()), bench.cycle)
        record = TaskRecord(context, (), 3, longest=4)
        for n in range(10):
            run = StepRun(n, Step("drive", DRIVING), "base_1", float(n))
            record.update([StepEnd(run, DRIVE, Success(), n + 0.5)])

    assert [step.start for step in record.steps] == [6.0, 7.0, 8.0, 9.0]
    assert record.forgotten == 6


def test_how_many_steps_went_before_those_in_the_report_is_said_in_it() -> None:
    with Bench(tiny_world()) as bench:
        made = (Step("drive", DRIVING),)
        task = bench.tasks.execute(made, iterate=3)
        bench.until(lambda: task.done)
        assert task.report is not None
        assert (len(task.report.steps), task.report.forgotten) == (3, 0)
