"""A task that needs a person: it asks, waits, and does what it is told."""

from __future__ import annotations

import pytest

from skiros_py.behaviours import Wait
from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.policy import Policy
from skiros_py.tasks.report import GoalReport, Outcome
from skiros_py.tasks.trace import TraceEventKind
from skiros_py.testing import Bench, answers, tiny_world
from skiros_py.testing.tiny import DRIVE, PICK, PLACE, pretend
from skiros_py.world.world import World

GOAL = "In(ball_1, slot_1)"
GIANT = "scene:giant_1 a tiny:Giant ; sk:in scene:box_a ."
ASKING = Policy(ask=True)


def begin(bench: Bench, *goal: str) -> TaskHandle:
    return bench.tasks.begin(bench.goal(*goal), name="kit 7", policy=ASKING)


def finish(bench: Bench, task: TaskHandle) -> GoalReport:
    bench.until(lambda: task.done)
    assert task.report is not None
    return task.report


def answer(bench: Bench, task: TaskHandle, choice: str) -> str:
    """Waits for the question, answers it, and returns its text."""
    bench.until(lambda: task.question is not None)
    assert task.question is not None
    assert task.status == "waiting"
    text = task.question.text
    bench.questions.answer(task.question.id, choice, by="ann")
    bench.cycle.step()
    return text


def with_a_giant() -> World:
    return tiny_world(GIANT)


def test_an_unreachable_condition_asks_a_person_with_reason_and_choices() -> None:
    with Bench(with_a_giant()) as bench:
        task = begin(bench, "In(giant_1, slot_2)", GOAL)
        bench.until(lambda: task.question is not None)
        bench.advance(5.0)
        (question,) = bench.questions.open

    assert question == task.question
    assert question.asker == "kit 7"
    assert question.options == ("retry", "done by hand", "skip", "abort")
    assert question.text.startswith("In(giant_1, slot_2) cannot be reached: skill 'place' would do it, but needs that ")
    assert "fits in" in question.text
    assert not task.done


def test_a_task_that_runs_out_of_plans_asks_a_person_and_goes_on_after_retry() -> None:
    with Bench(tiny_world()) as bench:
        moves = True

        def move_the_ball(event: ModuleEvent) -> None:
            if moves and event.module == "drive" and event.status is Status.STARTED:
                here = bench.world.objects("ball_1", "sk:in")[0]
                with bench.world.transaction("someone", "moved") as tx:
                    tx.relate("ball_1", "sk:in", "box_b" if here == "box_a" else "box_a")

        bench.monitor.subscribe(move_the_ball)
        task = begin(bench, GOAL)
        bench.until(lambda: task.question is not None)
        moves = False
        text = answer(bench, task, "retry")
        report = finish(bench, task)

    assert text.startswith(f"{GOAL} cannot be reached: gave up after 9 plans and retries: ")
    assert report.reached


def test_skip_gives_it_up_and_does_the_rest() -> None:
    with Bench(with_a_giant()) as bench:
        task = begin(bench, "In(giant_1, slot_2)", GOAL)
        answer(bench, task, "skip")
        report = finish(bench, task)

    giant, ball = report.conditions
    assert report.outcome is Outcome.PARTLY_REACHED
    assert giant.reason.startswith("skipped by ann: ")
    assert ball.believed


def test_done_by_hand_is_believed_on_the_persons_word_and_the_rest_is_done() -> None:
    with Bench(with_a_giant()) as bench:
        task = begin(bench, "In(giant_1, slot_2)", GOAL)
        answer(bench, task, "done by hand")
        report = finish(bench, task)
        change = next(c for c in bench.world.changes if c.author == "operator")

        assert bench.world.related("giant_1", "sk:in", "slot_2")
    assert change.reason == "done by hand, says ann"
    assert report.outcome is Outcome.REACHED


def test_done_by_hand_that_cannot_be_believed_is_asked_about_again_with_the_reason() -> None:
    with Bench(with_a_giant()) as bench:
        task = begin(bench, "In(Giant, slot_2)")
        answer(bench, task, "done by hand")
        again = answer(bench, task, "skip")
        report = finish(bench, task)

    assert again.startswith("In(Giant, slot_2) is still not believed")
    assert not report.reached


def test_retry_tries_again_with_what_is_so_now() -> None:
    world = with_a_giant()
    with Bench(world) as bench:
        bench.managers.close("arm_1")
        task = begin(bench, GOAL)
        first = answer(bench, task, "retry")
        second = answer(bench, task, "retry")
        bench.managers.open("arm_1")
        report = finish(bench, task)

    assert first == second
    assert report.reached


def test_it_is_back_look_again_puts_a_lost_thing_where_it_was_and_goes_on() -> None:
    with Bench(tiny_world()) as bench:
        lost = True

        def lose_the_ball(event: ModuleEvent) -> None:
            if lost and event.module == "drive" and event.status is Status.STARTED:
                lose(bench.world)

        bench.monitor.subscribe(lose_the_ball)
        task = begin(bench, GOAL)
        bench.until(lambda: task.question is not None)
        assert task.question is not None
        options = task.question.options
        lost = False
        answer(bench, task, "look again")
        report = finish(bench, task)
        told = [change.reason for change in bench.world.changes if change.author == "operator"]

    assert options == ("retry", "look again", "done by hand", "skip", "abort")
    assert told == ["it is back, says ann"]
    assert [step.skill for step in report.steps if not step.reason][-2:] == ["pick", "place"]
    assert report.reached


def lose(world: World) -> None:
    with world.transaction("someone", "looked") as tx:
        tx.place("ball_1", "sk:on", "unknown_location")
        tx.set("ball_1", "sk:missing", True)


def test_after_try_again_the_question_gives_the_reason_of_now() -> None:
    with Bench(tiny_world(), skills=(pretend(DRIVE), pretend(PICK, Wait(0.1)), pretend(PLACE))) as bench:
        task = begin(bench, GOAL)
        bench.until(lambda: task.question is not None)
        lose(bench.world)
        first = answer(bench, task, "retry")
        second = answer(bench, task, "skip")

    assert "failed tries" in first
    assert "failed tries" not in second
    assert "ball_1" in second


def test_abort_ends_the_whole_task() -> None:
    with Bench(with_a_giant()) as bench:
        task = begin(bench, "In(giant_1, slot_2)", GOAL)
        answer(bench, task, "abort")
        report = finish(bench, task)

    assert report.outcome is Outcome.STOPPED
    assert [e.text for e in task.trace.entries if e.what is TraceEventKind.STOPPED] == ["is stopped: aborted by ann"]


@pytest.mark.parametrize("ending", ["stop", "halt"])
def test_a_task_that_waits_for_a_person_can_be_ended_and_its_question_goes(ending: str) -> None:
    with Bench(with_a_giant()) as bench:
        task = begin(bench, "In(giant_1, slot_2)")
        bench.until(lambda: task.question is not None)
        if ending == "stop":
            task.stop()
            finish(bench, task)
        else:
            bench.cycle.stop_all("a hand was seen")

        assert task.done
        assert bench.questions.open == ()
        assert task.question is None


def test_a_target_that_keeps_failing_is_asked_about_before_it_is_given_up_and_a_retry_forgives() -> None:
    lying = (pretend(DRIVE), pretend(PICK, Wait(0.1)), pretend(PLACE))
    with Bench(tiny_world(), lying) as bench:
        task = begin(bench, GOAL)
        text = answer(bench, task, "retry")
        answer(bench, task, "skip")
        report = finish(bench, task)

    assert "gave up on ball_1 after 3 failed tries" in text
    assert [s.skill for s in report.steps].count("pick") == 6


def test_a_listener_can_answer_a_question_at_once() -> None:
    with Bench(with_a_giant()) as bench:
        person = answers(bench.questions, {"giant_1": "skip"})
        report = finish(bench, begin(bench, "In(giant_1, slot_2)", GOAL))

    assert len(person.asked) == 1
    assert report.outcome is Outcome.PARTLY_REACHED
