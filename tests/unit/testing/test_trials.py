"""One call tries a skill or a primitive, and tells everything of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import pytest

from skiros_py.behaviours import Do, P, Retry, Sequence
from skiros_py.devices.mobile_base import Base, BaseTwist
from skiros_py.errors import DeviceError, UnknownName
from skiros_py.execution.monitor import Status
from skiros_py.skills.context import QuestionKind
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill
from skiros_py.testing import (
    Bench,
    Breaks,
    Deaf,
    Dies,
    Fails,
    Frozen,
    Slow,
    answers,
    run_primitive,
    run_skill,
    tiny_world,
)
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, PICK, pretend


class Roll(Primitive["Roll.Params"]):
    """Drives ahead for a while, and says that it has arrived."""

    name: ClassVar[str] = "roll"

    @dataclass(frozen=True, slots=True)
    class Params:
        base: str = param("sk:Base", "The base.", kind=Kind.HARDWARE)
        robot: str = param("sk:Robot", "Its robot.", kind=Kind.PLANNING)
        place: str = param("sk:Location", "Where to.")
        seconds: float = param("number", "How long.", kind=Kind.OFFLINE, default=0.5, unit="s")

    def execute(self) -> Execution[Outcome]:
        base = Base(self.context.board, self.params.base)
        start = base.state.pose
        end = self.context.now + self.params.seconds
        while self.context.now < end:
            base.command(BaseTwist(0.5, 0.0))
            yield
        if base.state.pose.distance(start) < 0.1:
            return Failure("the base did not move")
        with self.world.transaction(author=self.name, reason="odometry") as tx:
            tx.place(self.params.robot, "sk:at", self.params.place)
        return Success("arrived")


ROLL = Do.of("roll", base=P("Base"), robot=P("Robot"), place=P("Location"))
ROLLING = Skill(DRIVE, ROLL)


def test_a_trial_of_a_skill_tells_how_it_ended_what_it_wrote_and_what_holds() -> None:
    trial = run_skill(ROLLING, tiny_world(), primitives=[Roll], Location="box_a")

    assert trial.check() is trial
    assert trial.reason == "arrived"
    assert trial.seconds == pytest.approx(0.5, abs=0.05)
    assert [(event.module, event.status) for event in trial.events if event.status is not Status.RUNNING] == [
        ("drive", Status.STARTED),
        ("roll", Status.STARTED),
        ("roll", Status.TERMINATED),
        ("drive", Status.TERMINATED),
    ]
    assert [change.author for change in trial.changes] == ["roll"]
    assert [verdict.holds for verdict in trial.verdicts] == [True]


def test_a_failed_trial_says_why_as_a_tree_with_events_and_changes() -> None:
    trial = run_skill(pretend(PICK), tiny_world(), Ball="ball_1")

    assert not trial
    with pytest.raises(AssertionError) as told:
        trial.check()
    text = str(told.value)
    assert "pick failed after" in text
    assert "robot_1 is not at box_a: it is at unknown_location" in text
    assert "Holding(gripper_1, ball_1) (does not hold)" in text
    assert "skill pick: error" in text


def test_the_implementation_that_is_given_is_the_one_that_runs_whichever_driver_it_is_for() -> None:
    for driver in ("fake", "real", None):
        skill = Skill(DRIVE, ROLL, driver=driver)

        assert run_skill(skill, tiny_world(), primitives=[Roll], Location="box_a").reason == "arrived"


def test_a_primitive_is_tried_alone_and_its_device_is_found() -> None:
    trial = run_primitive(Roll, tiny_world(), robot="robot_1", place="box_a", seconds=1.0)

    assert trial.succeeded
    assert trial.seconds == pytest.approx(1.0, abs=0.05)
    assert trial.verdicts == ()


# ------------------------------------------------------------------ faults


def test_a_deaf_base_makes_the_primitive_fail_as_its_author_meant_it() -> None:
    trial = run_primitive(Roll, tiny_world(), faults=[Deaf("base_1")], robot="robot_1", place="box_a")

    assert trial.reason == "the base did not move"
    assert trial.changes == ()


def test_a_cell_that_dies_ends_the_trial_with_its_fault() -> None:
    with pytest.raises(DeviceError, match="the cell does not answer"):
        run_skill(ROLLING, tiny_world(), primitives=[Roll], faults=[Dies(after=0.2)], Location="box_a")


@pytest.mark.parametrize("times", [0, 1, 2, 3])
def test_a_primitive_fails_so_many_times_and_works_then(times: int) -> None:
    skill = Skill(DRIVE, Retry(ROLL, 3))
    fault = Fails("roll", "wheels slip", times)

    trial = run_skill(skill, tiny_world(), primitives=[Roll], faults=[fault], Location="box_a")

    assert trial.succeeded == (times < 3)
    assert sum(event.text == "wheels slip" and event.module == "roll" for event in trial.events) == times


@pytest.mark.parametrize("exception", [ValueError("no"), RuntimeError("boom"), SystemExit(3)])
def test_a_primitive_that_breaks_is_named_with_what_it_raised(exception: BaseException) -> None:
    trial = run_skill(ROLLING, tiny_world(), primitives=[Roll], faults=[Breaks("roll", exception)], Location="box_a")

    assert trial.reason.startswith("roll broke: ")
    assert str(exception) in trial.reason


def test_a_slow_primitive_takes_longer() -> None:
    trial = run_skill(ROLLING, tiny_world(), primitives=[Roll], faults=[Slow("roll", 2.0)], Location="box_a")

    assert trial.succeeded
    assert trial.seconds == pytest.approx(2.5, abs=0.05)


def test_a_fault_of_a_primitive_that_is_not_there_is_refused() -> None:
    with pytest.raises(UnknownName, match="Did you mean 'roll'"):
        run_skill(ROLLING, tiny_world(), primitives=[Roll], faults=[Fails("rol")], Location="box_a")


@pytest.mark.parametrize("faults", [(), (Frozen("base_1", after=0.2),)])
def test_an_endless_run_is_stopped_at_the_limit_even_if_a_sensor_never_reports_standstill(
    faults: tuple[Frozen, ...],
) -> None:
    skill = Skill(DRIVE, Sequence.of(Do.of("roll", base=P("Base"), robot=P("Robot"), place=P("Location"), seconds=1e9)))

    trial = run_skill(skill, tiny_world(), primitives=[Roll], faults=faults, Location="box_a", limit=1.0)

    assert not trial
    assert trial.seconds < 1.5


# ------------------------------------------------------------------ questions


class Ask(Primitive["Ask.Params"]):
    """Asks whether to go on."""

    name: ClassVar[str] = "ask"

    @dataclass(frozen=True, slots=True)
    class Params:
        pass

    def execute(self) -> Execution[Outcome]:
        question = self.context.questions.ask(
            QuestionKind.CONFIRM, "Is the door open?", ("yes", "no"), asker=self.name, time=self.context.now
        )
        while question.answer is None:
            yield
        return Success() if question.answer == "yes" else Failure("the door is shut")


@pytest.mark.parametrize(("answer", "works"), [("yes", True), ("no", False)])
def test_questions_are_answered_as_given_and_told(answer: str, works: bool) -> None:
    trial = run_primitive(Ask, tiny_world(), answers={"door": answer})

    assert trial.succeeded is works
    assert [question.text for question in trial.questions] == ["Is the door open?"]


def test_a_question_that_no_answer_fits_stays_open() -> None:
    with Bench(tiny_world(), (), [Ask]) as bench:
        person = answers(bench.questions, {"window": "yes"})
        running = bench.start("ask")
        bench.advance(1.0)

        assert not running.done
        assert [question.text for question in person.unanswered] == ["Is the door open?"]
        bench.questions.answer(person.unanswered[0].id, "yes", by="test")
        assert bench.until(lambda: running.done) <= 0.01


# ------------------------------------------------------------------ time under control


def test_simulated_time_advances_only_on_request() -> None:
    with Bench(tiny_world(), (ROLLING,), [Roll], driver="any") as bench:
        running = bench.start("drive", Location="box_a")
        assert bench.time == 0.0
        bench.advance(0.25)

        assert bench.time == pytest.approx(0.25)
        assert not running.done
        assert bench.until(AT_LOCATION("robot_1", "box_a")) == pytest.approx(0.25, abs=0.02)


def test_a_wait_that_times_out_gives_the_reason() -> None:
    with Bench(tiny_world()) as bench, pytest.raises(AssertionError, match="robot_1 is not at box_b: it is at unknown"):
        bench.until(AT_LOCATION("robot_1", "box_b"), limit=0.1)


def test_pausing_a_run_stops_its_own_time() -> None:
    with Bench(tiny_world(), (ROLLING,), [Roll], driver="any") as bench:
        running = bench.start("drive", Location="box_a")
        bench.advance(0.2)
        running.pause()
        bench.advance(5.0)

        assert not running.done
        running.resume()
        bench.until(lambda: running.done, limit=1.0)
        assert running.result == Success("arrived")
