from __future__ import annotations

import time
from dataclasses import replace

import pytest

from skiros_py.behaviours import AssertEffects, Sequence, Wait
from skiros_py.errors import UnknownName, UsageError
from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.process import ThreadHost
from skiros_py.skills.conditions import Computed, ConditionType, Role, Verdict
from skiros_py.skills.outcome import Success
from skiros_py.tasks.context import TaskContext
from skiros_py.tasks.dispatcher import StepEnd
from skiros_py.tasks.handle import StepRun
from skiros_py.tasks.record import TaskRecord
from skiros_py.tasks.report import Outcome
from skiros_py.tasks.sequences import StepSequence
from skiros_py.tasks.task_manager import TaskManager
from skiros_py.testing import Bench, GivenPlanner, tiny_world
from skiros_py.testing.tiny import DRIVE, PICK, PLACE, pretend
from skiros_py.world.view import WorldView
from skiros_py.world.world import World

SKILLS = {skill.name: skill for skill in (DRIVE, PICK, PLACE)}
DRIVING = {"Base": "base_1", "Robot": "robot_1", "Location": "box_a"}
HAND = {"Arm": "arm_1", "Gripper": "gripper_1", "Robot": "robot_1"}


def sequence(world: World) -> StepSequence:
    """Drive, pick, place of ball_1, from scratch."""
    made = StepSequence(world, SKILLS)
    made.add("drive", Base="base_1", Robot="robot_1", Location="box_a")
    made.add("pick", **HAND, Box="box_a", Ball="ball_1")
    made.add("place", **HAND, Ball="ball_1", Slot="slot_1")
    return made


# ------------------------------------------------------------------ editing


def test_a_sequence_from_scratch_is_checked_step_by_step() -> None:
    made = StepSequence(tiny_world(), SKILLS)

    (alone,) = made.add("pick", **HAND, Box="box_a", Ball="ball_1")
    assert alone.problems == ("robot_1 is not at box_a: it is at unknown_location",)
    drive, pick = made.insert(0, "drive", Base="base_1", Robot="robot_1", Location="box_a")
    assert (drive.works, pick.works, made.works) == (True, True, True)


def test_a_removed_step_breaks_what_needs_it_and_only_that() -> None:
    made = sequence(tiny_world())

    drive, place = made.remove(1)
    assert drive.works
    assert place.problems == ("ball_1 is not heldBy gripper_1: it is in box_a",)


def test_steps_can_be_moved_and_moved_back() -> None:
    made = sequence(tiny_world())

    assert [check.works for check in made.move(0, 2)] == [False, True, True]
    assert [step.skill for step in made.steps] == ["pick", "place", "drive"]
    assert all(check.works for check in made.move(2, 0))


def test_a_changed_parameter_is_checked_too() -> None:
    made = sequence(tiny_world())

    assert [check.works for check in made.change(0, Location="box_b")] == [True, False, True]
    assert [check.works for check in made.change(0, Location="box_a")] == [True, True, True]
    made.change(0, Robot=None)
    assert dict(made.steps[0].arguments) == {"Base": "base_1", "Location": "box_a"}


def test_a_check_is_of_the_world_as_it_is_now() -> None:
    world = tiny_world()
    made = sequence(world)
    with world.transaction("somebody", "moved it") as tx:
        tx.place("ball_1", "sk:in", "box_b")

    assert made.checks[1].problems == ("ball_1 is not in box_a: it is in box_b",)
    assert made.checks[1].as_json()["works"] is False


@pytest.mark.parametrize(
    ("edit", "says"),
    [
        (lambda s: s.add("fly"), "unknown skill 'fly'"),
        (lambda s: s.add("drive", Wings="base_1"), "Wings"),
        (lambda s: s.add("drive", Base="base_7"), "base_7"),
        (lambda s: s.add("drive", Base="box_a"), "box_a"),
        (lambda s: s.remove(3), "a number from 0 to 2, not 3"),
        (lambda s: s.remove(-1), "a number from 0 to 2, not -1"),
        (lambda s: s.insert(4, "drive"), "a number from 0 to 3, not 4"),
        (lambda s: s.move(0, 3), "a number from 0 to 2, not 3"),
        (lambda s: s.change(9, Location="box_b"), "a number from 0 to 2, not 9"),
        (lambda s: s.remove("1"), "not '1'"),
        (lambda s: s.remove(True), "not True"),
    ],
)
def test_an_edit_that_names_what_is_not_there_is_refused_and_changes_nothing(edit: object, says: str) -> None:
    made = sequence(tiny_world())
    before = made.steps

    with pytest.raises(UsageError) as refusal:
        edit(made)  # type: ignore[operator]
    assert says in str(refusal.value)
    assert made.steps == before


def test_an_empty_sequence_has_no_place_for_an_edit_and_cannot_be_run() -> None:
    empty = StepSequence(tiny_world(), SKILLS)

    with pytest.raises(UsageError, match="there is none"):
        empty.remove(0)
    with pytest.raises(UsageError, match="no steps"):
        empty.require_works()


def test_a_sequence_reads_as_text() -> None:
    made = sequence(tiny_world())
    made.remove(0)

    assert str(made).splitlines() == [
        " 1. pick box_a ball_1 - robot_1 is not at box_a: it is at unknown_location",
        " 2. place ball_1 slot_1",
    ]


# ------------------------------------------------------------------ running


def test_a_plan_can_be_edited_and_run() -> None:
    with Bench(tiny_world()) as bench:
        plan = bench.plan("In(ball_1, slot_1)").outcome
        assert isinstance(plan, Plan)
        made = StepSequence(bench.world, SKILLS, plan)
        made.change(2, Slot="slot_2")
        task = bench.tasks.execute(made)
        bench.until(lambda: task.done)

        assert bench.world.related("ball_1", "sk:in", "slot_2")
    assert task.report is not None
    assert task.report.outcome is Outcome.REACHED
    assert [step.skill for step in task.report.steps] == ["drive", "pick", "place"]


def test_an_edited_plan_that_cannot_work_is_refused_with_the_step_and_the_reason() -> None:
    with Bench(tiny_world()) as bench:
        made = sequence(bench.world)
        made.remove(0)

        with pytest.raises(UsageError) as refusal:
            bench.tasks.execute(made)
        assert bench.tasks.active == ()
    assert "step 1 (pick box_a ball_1): robot_1 is not at box_a: it is at unknown_location" in str(refusal.value)


def test_what_cannot_work_can_be_asked_for_all_the_same_and_fails_at_that_step() -> None:
    with Bench(tiny_world()) as bench:
        made = sequence(bench.world)
        made.remove(0)
        task = bench.tasks.execute(made, anyway=True)
        bench.until(lambda: task.done)

    report = task.report
    assert report is not None
    assert not report.reached
    assert report.fault.startswith("arm_1: pick box_a ball_1 failed 3 times: precondition At(robot_1, box_a)")
    assert [step.skill for step in report.steps] == ["pick"] * 3


def test_a_sequence_is_repeated_so_often_as_wanted() -> None:
    with Bench(tiny_world()) as bench:
        made = bench.tasks.sequence()
        made.add("drive", Base="base_1", Robot="robot_1", Location="box_a")
        made.add("drive", Base="base_1", Robot="robot_1", Location="box_b")
        task = bench.tasks.execute(made, iterate=3)
        bench.until(lambda: task.done)

    assert task.report is not None
    assert [step.arguments["Location"] for step in task.report.steps] == ["box_a", "box_b"] * 3


def test_a_sequence_is_repeated_until_it_is_stopped() -> None:
    with Bench(tiny_world(), (pretend(DRIVE, Sequence.of(Wait(0.2), AssertEffects(0.0))),)) as bench:
        made = bench.tasks.sequence()
        made.add("drive", Base="base_1", Robot="robot_1", Location="box_a")
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
        task = bench.tasks.execute(sequence(bench.world), iterate=2)
        bench.until(lambda: task.done)

    report = task.report
    assert report is not None
    assert len(report.steps) == 3
    assert report.fault == "round 2 cannot work: pick box_a ball_1: ball_1 is not in box_a: it is in slot_1"


@pytest.mark.parametrize("iterate", [1, None])
def test_a_sequence_without_steps_is_refused_even_where_it_shall_run_anyway(iterate: int | None) -> None:
    with Bench(tiny_world()) as bench, pytest.raises(UsageError, match="no steps"):
        bench.tasks.execute(bench.tasks.sequence(), iterate=iterate, anyway=True)


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
        task = _not_in_lockstep(bench).execute(_drives(bench, 30), anyway=True)
        begun = bench.cycle.board.snapshot.cycle
        bench.until(lambda: bench.events, limit=1e5)
        assert bench.cycle.board.snapshot.cycle - begun >= 30
        bench.until(lambda: task.done, limit=1e5)

    assert task.report is not None
    assert len(task.report.steps) == 30


def test_a_sequence_is_stopped_while_its_steps_are_checked() -> None:
    with Bench(tiny_world(), (_PONDERING,)) as bench:
        bench.cycle.pace = 1000.0
        task = _not_in_lockstep(bench).execute(_drives(bench, 30), anyway=True)
        bench.cycle.step()
        task.stop("enough")
        bench.cycle.step()
        bench.cycle.step()

    assert task.report is not None
    assert task.report.outcome is Outcome.STOPPED
    assert bench.events == []


def _not_in_lockstep(bench: Bench) -> TaskManager:
    planning = ThreadHost(bench.world, GivenPlanner())
    return TaskManager(TaskContext(bench.world, bench.managers, planning, bench.cycle, lockstep=False))


def _drives(bench: Bench, count: int) -> StepSequence:
    made = StepSequence(bench.world, {_PONDERING.description.name: _PONDERING.description})
    for number in range(count):
        made.add("drive", Base="base_1", Robot="robot_1", Location=("box_a", "box_b")[number % 2])
    return made


@pytest.mark.parametrize("often", [0, -1, 1.5, True, "2"])
def test_how_often_is_a_whole_number(often: object) -> None:
    with Bench(tiny_world()) as bench, pytest.raises(UsageError, match="iterate"):
        bench.tasks.execute(sequence(bench.world), iterate=often)  # type: ignore[arg-type]


def test_a_skill_that_goes_away_is_a_problem_of_its_step() -> None:
    with Bench(tiny_world()) as bench:
        task = bench.tasks.execute(sequence(bench.world))
        bench.managers.close("arm_1")
        bench.until(lambda: task.done)

    assert task.report is not None
    assert "pick" in task.report.fault
    with pytest.raises(UnknownName):
        bench.tasks.sequence().add("pick")


# ------------------------------------------------------------------ what is left out


def test_what_a_step_leaves_out_is_inferred_for_its_check_too() -> None:
    made = StepSequence(tiny_world(), SKILLS)

    (alone,) = made.add("place", Ball="ball_1", Slot="slot_1")
    assert alone.agent == "arm_1"
    assert "ball_1 is not heldBy gripper_1: it is in box_a" in alone.problems
    made.insert(0, "pick", Ball="ball_1")
    made.insert(0, "drive", Location="box_a")
    assert made.works, str(made)


def test_a_sequence_that_leaves_nearly_everything_out_is_run() -> None:
    with Bench(tiny_world()) as bench:
        made = bench.tasks.sequence()
        made.add("drive", Location="box_a")
        made.add("pick", Ball="ball_1")
        made.add("place", Slot="slot_2")
        task = bench.tasks.execute(made)
        bench.until(lambda: task.done)

        assert bench.world.related("ball_1", "sk:in", "slot_2")
    assert task.report is not None
    assert task.report.reached, task.report.fault


def test_who_drove_there_is_who_picks_where_nobody_says_who() -> None:
    with Bench(tiny_world(robots=2)) as bench:
        made = bench.tasks.sequence()
        made.add("drive", Base="base_2", Location="box_a")
        made.add("pick", Ball="ball_1")
        task = bench.tasks.execute(made)
        bench.until(lambda: task.done)

        assert bench.world.related("ball_1", "sk:heldBy", "gripper_2"), str(task.trace)


def test_a_step_without_an_agent_is_done_by_somebody_who_is_there() -> None:
    with Bench(tiny_world(robots=2)) as bench:
        bench.managers.close("base_1")
        made = bench.tasks.sequence()
        made.add("drive", Location="box_a")
        task = bench.tasks.execute(made)
        bench.until(lambda: task.done)

    assert task.report is not None
    assert [(step.agent, step.reason) for step in task.report.steps] == [("base_2", "")]


def test_a_step_that_nobody_who_is_there_can_do_ends_the_sequence_before_it_begins() -> None:
    with Bench(tiny_world()) as bench:
        made = bench.tasks.sequence()
        made.add("drive", Location="box_a")
        bench.managers.close("base_1")
        task = bench.tasks.execute(made, anyway=True)
        bench.until(lambda: task.done)

    assert task.report is not None
    assert task.report.fault == "round 1 cannot work: drive: no subsystem has the skill drive any more"
    assert task.report.steps == ()


def test_a_step_whose_target_is_left_open_and_that_fails_is_tried_again_and_given_up() -> None:
    with Bench(tiny_world(), (pretend(DRIVE), pretend(PICK, Wait(0.1)))) as bench:
        made = bench.tasks.sequence()
        made.add("drive", Location="box_a")
        made.add("pick", Box="box_a")
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
        made = StepSequence(bench.world, SKILLS)
        made.add("drive", **DRIVING)
        task = bench.tasks.execute(made, iterate=3)
        bench.until(lambda: task.done)
        assert task.report is not None
        assert (len(task.report.steps), task.report.forgotten) == (3, 0)
