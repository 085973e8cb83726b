from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import pytest

from skiros_py.behaviours import AssertEffects, Behaviour, Do, Fallback, P, Retry, Sequence
from skiros_py.execution.monitor import Status
from skiros_py.skills.outcome import CANCELLED, Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, Param, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, EMPTY_HANDED, REACHABLE
from skiros_py.world.world import World

TO_A = {"Base": "base_1", "Robot": "robot_1", "Location": "box_a"}
AFTER = replace(DRIVE, pre=(), post=(AT_LOCATION("Robot", "Location"),))


class Note(Primitive[Any]):
    """Writes into a log in which cycle it runs, for so many cycles, and ends as told."""

    name: ClassVar[str] = "note"
    log: ClassVar[list[tuple[str, int]]] = []

    @dataclass(frozen=True, slots=True)
    class Params:
        text: str | None = param("text", "What to write.", kind=Kind.OPTIONAL, default=None)
        cycles: int = param("number", "How many cycles to run.", default=1)
        ends: str = param("text", "'well', or why it fails.", default="well")
        goes: str = param("text", "Where the robot is afterwards.", default="")

    def _write(self, what: str) -> None:
        self.log.append((what, self.context.board.snapshot.cycle))

    def execute(self) -> Execution[Outcome]:
        try:
            for _ in range(self.params.cycles):
                self._write(self.params.text)
                yield
        finally:
            self._write(f"{self.params.text} ends")
        if self.params.goes:
            with self.world.transaction("note", "arrived") as tx:
                tx.place("robot_1", "sk:at", self.params.goes)
        return Success() if self.params.ends == "well" else Failure(self.params.ends)

    def recover(self) -> Execution[None]:
        for _ in range(2):
            self._write(f"{self.params.text} recovers")
            yield


@pytest.fixture(autouse=True)
def _fresh() -> None:
    Note.log.clear()


def note(text: str, **more: Any) -> Do:
    return Do.of("note", text=text, **more)


def bench_with(body: Behaviour, world: World | None = None, **skill: Any) -> Bench:
    description = skill.pop("description", AFTER)
    return Bench(world or tiny_world(), (Skill(description, body, driver="fake", **skill),), (Note,))


def run(body: Behaviour, arguments: Mapping[str, str] = TO_A, **skill: Any) -> Outcome:
    with bench_with(body, **skill) as bench:
        return bench.run("drive", **arguments)


def texts() -> list[str]:
    return [text for text, _ in Note.log if "ends" not in str(text)]


def test_the_order_is_pre_sense_body_finish() -> None:
    outcome = run(note("body", goes="box_a"), pre_sense=note("sense"), finish=note("finish"))

    assert isinstance(outcome, Success)
    assert texts() == ["sense", "body", "finish"]


def test_preconditions_are_checked_after_sensing() -> None:
    needs = replace(DRIVE, pre=(AT_LOCATION("Robot", "Location"),))

    assert isinstance(run(note("body"), description=needs, pre_sense=note("sense", goes="box_a")), Success)


def test_a_failing_precondition_keeps_body_and_finish_from_running_and_says_why() -> None:
    outcome = run(
        note("body"),
        {**TO_A, "Location": "floor"},
        description=replace(AFTER, pre=(REACHABLE("Location"),)),
        finish=note("finish"),
    )

    assert outcome == Failure("precondition Reachable(floor): floor has no drivingPose")
    assert texts() == []


def test_a_failing_postcondition_makes_a_body_that_worked_a_failure_after_its_finish() -> None:
    outcome = run(note("body"), finish=note("finish"))

    assert isinstance(outcome, Failure)
    assert outcome.reason == ("postcondition At(robot_1, box_a): robot_1 is not at box_a: it is at unknown_location")
    assert texts() == ["body", "finish"]


def test_finish_runs_after_a_failing_body_and_keeps_its_reason() -> None:
    assert run(note("body", ends="slipped"), finish=note("finish")) == Failure("slipped")
    assert texts() == ["body", "finish"]


def test_a_failing_finish_fails_a_skill_that_worked() -> None:
    assert run(note("body", goes="box_a"), finish=note("finish", ends="stuck")) == Failure("stuck")


def test_in_a_sequence_a_successor_starts_in_the_very_next_cycle() -> None:
    run(Sequence.of(note("a", cycles=2), note("b"), note("c", goes="box_a")))

    cycles = dict(Note.log)
    assert cycles["b"] == cycles["a ends"] + 1
    assert cycles["c"] == cycles["b ends"] + 1


def test_a_sequence_ends_with_its_first_failure() -> None:
    assert run(Sequence.of(note("a"), note("b", ends="slipped"), note("c"))) == Failure("slipped")
    assert texts() == ["a", "b"]


def test_a_fallback_ends_with_its_first_success() -> None:
    run(Fallback.of(note("a", ends="no"), note("b", goes="box_a"), note("c")))

    assert texts() == ["a", "b"]


def test_a_fallback_of_failures_fails_for_the_last_reason() -> None:
    assert run(Fallback.of(note("a", ends="first"), note("b", ends="second"))) == Failure("second")


def test_a_retry_tries_the_given_number_of_times_each_in_the_next_cycle() -> None:
    assert run(Retry(note("a", ends="no"), 3)) == Failure("no")

    ends = [cycle for text, cycle in Note.log if text == "a ends"]
    starts = [cycle for text, cycle in Note.log if text == "a"]
    assert texts() == ["a"] * 3
    assert starts[1:] == [cycle + 1 for cycle in ends[:-1]]


def test_a_retry_ends_with_the_first_success() -> None:
    run(Retry(note("a", goes="box_a"), 3))

    assert texts() == ["a"]


def test_parameters_of_the_skill_reach_its_primitives() -> None:
    run(note(P("Location"), goes="box_a"))

    assert texts() == ["box_a"]


def test_a_missing_primitive_is_named() -> None:
    outcome = run(Do.of("noted"))

    assert isinstance(outcome, Failure)
    assert "unknown module 'noted'" in outcome.reason
    assert "mean 'note'" in outcome.reason


def test_stopping_closes_the_generators_at_once() -> None:
    with bench_with(Sequence.of(note("a", cycles=99), note("b")), finish=note("finish")) as bench:
        task = bench.managers["base_1"].start("drive", TO_A)
        for _ in range(3):
            bench.cycle.step()
        task.stop()
        for _ in range(5):
            bench.cycle.step()

    assert Note.log[-1][0] == "a ends"
    assert [e.status for e in bench.events if e.module == "drive"] == [Status.STARTED, Status.RUNNING, Status.PREEMPTED]


def test_cancelling_closes_the_body_runs_recover_and_then_the_finish() -> None:
    with bench_with(Sequence.of(note("a", cycles=99), note("b")), finish=note("finish")) as bench:
        outcome = bench.run("drive", cancel=lambda: "something changed" if len(Note.log) > 0 else "", **TO_A)

    assert outcome == Failure("something changed", CANCELLED)
    assert [text for text, _ in Note.log] == ["a", "a ends", "a recovers", "a recovers", "finish", "finish ends"]
    recovering = [cycle for text, cycle in Note.log if text == "a recovers"]
    assert recovering == [recovering[0], recovering[0] + 1], "one tick per cycle"


def test_a_hold_condition_that_becomes_false_cancels_the_skill_with_its_reason() -> None:
    world = tiny_world()
    gripper = replace(DRIVE.params[0], key="Gripper", type="sk:Gripper")
    steady = replace(AFTER, params=(*AFTER.params, gripper), hold=(EMPTY_HANDED("Gripper"),))

    with bench_with(note("a", cycles=99), world, description=steady) as bench:
        task = bench.managers["base_1"].start("drive", {**TO_A, "Gripper": "gripper_1"})
        for _ in range(5):
            bench.cycle.step()
        assert not task.done
        with world.transaction("test", "gave it a ball") as tx:
            tx.place("ball_1", "sk:heldBy", "gripper_1")
        outcome = bench.cycle.run(task)

    assert outcome == Failure("hold condition EmptyHanded(gripper_1): ball_1 heldBy gripper_1")


def test_a_fake_writes_all_effects_in_one_change_by_its_name() -> None:
    world = tiny_world()
    with Bench(world) as bench:
        before = world.version
        bench.run("drive", **TO_A)

    (change,) = world.changes_since(before)
    assert (change.author, change.reason) == ("drive", "pretended by a fake")


def test_a_fake_skill_takes_its_declared_duration() -> None:
    with bench_with(AssertEffects(0.5)) as bench:
        bench.run("drive", **TO_A)

        assert bench.cycle.board.snapshot.time == pytest.approx(0.5, abs=0.02)


def test_the_monitor_receives_all_events_in_order() -> None:
    with bench_with(Sequence.of(note("a"), note("b", ends="slipped"))) as bench:
        bench.run("drive", **TO_A)

    assert [(e.kind, e.module, e.status) for e in bench.events] == [
        ("skill", "drive", Status.STARTED),
        ("primitive", "note", Status.STARTED),
        ("primitive", "note", Status.TERMINATED),
        ("primitive", "note", Status.STARTED),
        ("primitive", "note", Status.ERROR),
        ("skill", "drive", Status.ERROR),
    ]
    assert bench.events[-1].text == "slipped"
    assert bench.events[-1].code < 0


def test_a_failing_pre_sense_is_the_skills_failure_and_nothing_else_runs() -> None:
    outcome = run(note("body"), pre_sense=note("sense", ends="too dark"), finish=note("finish"))

    assert outcome == Failure("too dark")
    assert texts() == ["sense"]


def test_body_and_finish_each_start_in_the_very_next_cycle() -> None:
    run(note("body", goes="box_a"), pre_sense=note("sense"), finish=note("finish"))

    cycles = dict(Note.log)
    assert cycles["body"] == cycles["sense ends"] + 1
    assert cycles["finish"] == cycles["body ends"] + 1


SPEED = Param("Speed", "text", "How fast.", Kind.OFFLINE, "fast")
WISH = Param("Wish", "text", "What else.", Kind.OPTIONAL)
WORD = Param("Word", "text", "What to say.")


def with_params(*params: Param) -> SkillDescription:
    return replace(AFTER, params=(*AFTER.params, *params))


def test_a_parameter_with_a_default_need_not_be_specified() -> None:
    outcome = run(note(P("Speed"), goes="box_a"), description=with_params(SPEED))

    assert isinstance(outcome, Success)
    assert texts() == ["fast"]


def test_a_specified_value_takes_precedence_over_the_default() -> None:
    run(note(P("Speed"), goes="box_a"), {**TO_A, "Speed": "slow"}, description=with_params(SPEED))

    assert texts() == ["slow"]


def test_an_optional_parameter_may_stay_unspecified() -> None:
    outcome = run(note(P("Wish"), goes="box_a"), description=with_params(WISH))

    assert isinstance(outcome, Success)
    assert Note.log[0][0] is None


@pytest.mark.parametrize(("arguments", "missing"), [(TO_A, "Word"), ({"Base": "base_1", "Robot": "robot_1"}, "Word")])
def test_a_parameter_that_must_be_specified_and_is_not_fails_the_skill_by_its_name(
    arguments: Mapping[str, str], missing: str
) -> None:
    outcome = run(note("body"), arguments, description=with_params(WORD), finish=note("finish"))

    assert isinstance(outcome, Failure)
    assert f"parameter {missing} not specified" in outcome.reason
    assert texts() == []
