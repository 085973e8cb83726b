"""What each kind of node does, cycle by cycle."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import pytest

from skiros_py.behaviours import (
    AssertEffects,
    Behaviour,
    Check,
    Do,
    Every,
    Fallback,
    ForEach,
    Guard,
    P,
    Parallel,
    Policy,
    Repeat,
    Retry,
    Sequence,
    Start,
    Timeout,
    Wait,
    WaitUntil,
    lines,
    walk,
)
from skiros_py.devices.arm import Arm
from skiros_py.errors import DescriptionError
from skiros_py.execution.monitor import Status
from skiros_py.ports.signals import Input, Signal
from skiros_py.skills.conditions import Related
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import AT_LOCATION, DRIVE

LOG: list[tuple[str, int]] = []
AFTER = replace(DRIVE, pre=(), post=(AT_LOCATION("Robot", "Location"),))
TO_A = {"Base": "base_1", "Robot": "robot_1", "Location": "box_a"}


class Step(Primitive[Any]):
    """Writes into a log in which cycle it runs, for so many cycles, and ends as told."""

    name: ClassVar[str] = "step"

    @dataclass(frozen=True, slots=True)
    class Params:
        text: str = param("text", "What to write.")
        cycles: int = param("integer", "How many cycles to run.", default=1, unit="1")
        ends: str = param("text", "'well', or why it fails.", default="well")

    def execute(self) -> Execution[Outcome]:
        for _ in range(self.params.cycles):
            LOG.append((self.params.text, self.context.board.snapshot.cycle))
            yield
        return Success(self.params.text) if self.params.ends == "well" else Failure(self.params.ends)

    def stop(self) -> None:
        LOG.append((f"{self.params.text} stops", self.context.board.snapshot.cycle))

    def recover(self) -> Execution[None]:
        for _ in range(2):
            LOG.append((f"{self.params.text} recovers", self.context.board.snapshot.cycle))
            yield


class Far(Primitive[Any]):
    """Fails with its cause as data."""

    name: ClassVar[str] = "far"

    @dataclass(frozen=True, slots=True)
    class Params:
        pass

    def execute(self) -> Execution[Outcome]:
        yield
        return Failure("too far", values={"cause": "reach"})


class Hold(Primitive[Any]):
    """Holds an arm for some cycles."""

    name: ClassVar[str] = "hold_arm"

    @dataclass(frozen=True, slots=True)
    class Params:
        arm: str = param("sk:Arm", "The arm.", kind=Kind.HARDWARE)
        text: str = param("text", "What to write.")

    def execute(self) -> Execution[Outcome]:
        arm = Arm(self.context.board, self.params.arm)
        for _ in range(3):
            LOG.append((f"{self.params.text} has {arm.id}", self.context.board.snapshot.cycle))
            yield
        return Success()


class Arrive(Primitive[Any]):
    """Says where the robot is."""

    name: ClassVar[str] = "arrive"

    @dataclass(frozen=True, slots=True)
    class Params:
        place: str = param("sk:Location", "Where.")

    def execute(self) -> Execution[Outcome]:
        yield
        with self.world.transaction(self.name, "localised") as tx:
            tx.place("robot_1", "sk:at", self.params.place)
        return Success()


@pytest.fixture(autouse=True)
def _fresh() -> Iterator[None]:
    LOG.clear()
    yield
    LOG.clear()


def step(text: str, **more: Any) -> Do:
    return Do.of("step", text=text, **more)


def bench_for(body: Behaviour, *others: Skill, **skill: Any) -> Bench:
    mine = Skill(skill.pop("description", AFTER), body, driver="fake", **skill)
    return Bench(tiny_world(), (mine, *others), (Step, Far, Hold, Arrive))


def test_what_is_started_runs_on_beside_the_skill_and_after_it_and_only_once() -> None:
    watching = Start.of("step", text="watching", cycles=60)
    body = Sequence.of(watching, watching, step("works", cycles=3), Do.of("arrive", place="box_a"))
    with bench_for(body) as bench:
        assert isinstance(bench.run("drive", **TO_A), Success)
        during = [cycle for text, cycle in LOG if text == "watching"]
        bench.advance(0.5)

    watched = [cycle for text, cycle in LOG if text == "watching"]
    works = [cycle for text, cycle in LOG if text == "works"]
    assert 0 < len(during) < 60
    assert set(works) & set(during)
    assert len(watched) == len(set(watched)) == 60


def test_what_cannot_be_started_is_the_failure_of_the_node() -> None:
    with bench_for(Start.of("no_such_module")) as bench:
        outcome = bench.run("drive", **TO_A)

    assert isinstance(outcome, Failure)
    assert "no_such_module" in outcome.reason


def outcome_of(body: Behaviour, *others: Skill, **skill: Any) -> Outcome:
    with bench_for(body, *others, **skill) as bench:
        return bench.run("drive", **TO_A)


ARRIVE = Do.of("arrive", place=P("Location"))


def ends_well(*nodes: Behaviour) -> Outcome:
    return outcome_of(Sequence.of(*nodes, ARRIVE))


def cycles(text: str) -> list[int]:
    return [cycle for what, cycle in LOG if what == text]


def texts() -> list[str]:
    return [text for text, _ in LOG]


# ---------------------------------------------------------------- parallel


def test_parallel_branches_run_in_the_same_cycles() -> None:
    assert isinstance(ends_well(Parallel.of(step("a", cycles=3), step("b", cycles=3))), Success)
    assert cycles("a") == cycles("b")


def test_the_first_failure_cancels_the_other_branches_which_recover() -> None:
    both = Parallel.of(step("slow", cycles=99), step("bad", cycles=2, ends="no luck"))

    assert outcome_of(both) == Failure("no luck")
    assert texts()[-3:] == ["slow stops", "slow recovers", "slow recovers"]


def test_the_first_success_cancels_the_other_branches() -> None:
    race = Parallel.of(step("slow", cycles=99), step("quick"), policy=Policy.FIRST_SUCCESS)

    assert isinstance(ends_well(race), Success)
    assert "slow stops" in texts()


def test_a_race_without_a_winner_gives_the_reason_of_each_branch() -> None:
    race = Parallel.of(step("a", ends="flat tyre"), step("b", cycles=3, ends="wrong way"), policy=Policy.FIRST_SUCCESS)

    assert outcome_of(race) == Failure("flat tyre; wrong way")


def test_all_waits_for_every_branch_and_fails_if_one_fails() -> None:
    together = Parallel.of(step("bad", ends="no luck"), step("good", cycles=5), policy=Policy.ALL)

    assert outcome_of(together) == Failure("no luck")
    assert len(cycles("good")) == 5


@pytest.mark.parametrize(
    ("node", "reason"),
    [
        (Parallel.of(step("good"), Do.of("far"), policy=Policy.ALL), "too far"),
        (ForEach("Ball", "tiny:Ball", Do.of("far")), "ball_1: too far"),
    ],
)
def test_a_cause_as_data_is_passed_on(node: Behaviour, reason: str) -> None:
    assert outcome_of(node) == Failure(reason, values={"cause": "reach"})


def test_branches_that_need_one_device_take_turns() -> None:
    both = Parallel.of(Do.of("hold_arm", arm="arm_1", text="a"), Do.of("hold_arm", arm="arm_1", text="b"))

    assert isinstance(outcome_of(Sequence.of(both, ARRIVE), takes=("Robot",)), Success)
    assert max(cycles("a has arm_1")) < min(cycles("b has arm_1"))


def test_a_device_that_the_skill_did_not_declare_is_refused_by_name() -> None:
    outcome = outcome_of(Do.of("hold_arm", arm="arm_1", text="a"))

    assert isinstance(outcome, Failure)
    assert "arm_1" in outcome.reason
    assert "declare" in outcome.reason


# ---------------------------------------------------------------- repeat, time, guard


def test_repeat_runs_the_given_number_of_times_without_an_idle_cycle() -> None:
    assert isinstance(ends_well(Repeat(step("a"), 4)), Success)
    first = cycles("a")[0]
    assert cycles("a") == [first + 2 * n for n in range(4)]  # a tick in which it runs, one in which it ends


def test_repeat_without_a_number_ends_with_the_first_failure() -> None:
    assert outcome_of(Repeat(step("a", ends="worn out"))) == Failure("worn out")


def test_a_timeout_cancels_its_child_which_recovers() -> None:
    outcome = outcome_of(Timeout(step("a", cycles=999), 0.1))

    assert outcome == Failure("took longer than 0.1 s")
    assert len(cycles("a")) == pytest.approx(20, abs=1)
    assert texts()[-2:] == ["a recovers"] * 2


def test_a_timeout_that_is_not_reached_changes_nothing() -> None:
    assert isinstance(ends_well(Timeout(step("a"), 5.0)), Success)


def test_a_guard_ends_its_child_when_a_condition_holds_no_longer() -> None:
    there = AT_LOCATION("Robot", "Location")
    away = Sequence.of(Wait(0.05), Do.of("arrive", place="box_b"))
    body = Sequence.of(ARRIVE, Parallel.of(away, Guard.of(step("a", cycles=999), there)))

    outcome = outcome_of(body)

    assert isinstance(outcome, Failure)
    assert "no longer" in outcome.reason
    assert "box_b" in outcome.reason
    assert texts()[-3:] == ["a stops", "a recovers", "a recovers"]


def test_expressions_over_signals_are_waited_for_guarded_and_checked() -> None:
    skill = Skill(
        AFTER,
        Sequence.of(ARRIVE, WaitUntil.of("level > 0.5"), Guard.of(step("a", cycles=999), "level < 2"), step("b")),
        driver="fake",
    )
    level = Input(Signal("level"), 0.0)
    with Bench(tiny_world(), (skill,), (Step, Far, Hold, Arrive), signals=lambda _cell: [level]) as bench:
        running = bench.start("drive", **TO_A)
        bench.advance(0.1)
        assert texts() == []

        bench.signals.set("level", 1.0)
        bench.advance(0.1)
        assert set(texts()) == {"a"}

        bench.signals.set("level", 3.0)
        bench.advance(0.1)

    assert running.result == Failure("no longer level < 2: level is 3, not level < 2")
    assert texts()[-3:] == ["a stops", "a recovers", "a recovers"]


def test_a_check_takes_no_time_and_gives_the_reason() -> None:
    outcome = outcome_of(Check.of(AT_LOCATION("Robot", "Location")))

    assert isinstance(outcome, Failure)
    assert "robot_1 is not at box_a: it is at unknown_location" in outcome.reason


# ---------------------------------------------------------------- for each


def test_for_each_runs_once_per_element_that_a_query_finds() -> None:
    every = ForEach("Ball", "tiny:Ball", step("found", cycles=1))

    assert isinstance(ends_well(every), Success)
    assert len(cycles("found")) == 2


def test_for_each_passes_each_matching_element_to_its_child() -> None:
    in_box = ForEach("Box", "tiny:Box", Do.of("arrive", place=P("Box")), Related("sk:at", "Robot", "Location"))

    assert isinstance(outcome_of(Sequence.of(in_box, ARRIVE)), Success)
    with bench_for(Sequence.of(ForEach("Box", "tiny:Box", Do.of("arrive", place=P("Box"))), ARRIVE)) as bench:
        bench.run("drive", **TO_A)
        places = [e.text for e in bench.events if e.module == "arrive" and e.status is Status.STARTED]
    assert places == ["place=box_a", "place=box_b", "place=box_a"]


def test_for_each_over_nothing_succeeds() -> None:
    assert isinstance(ends_well(ForEach("Cart", "tiny:Giant", step("never"))), Success)
    assert "never" not in texts()


# ---------------------------------------------------------------- skills within skills


def outer(body: Behaviour) -> Skill:
    return Skill(replace(AFTER, name="tour"), body, driver="fake")


def run_tour(body: Behaviour, *others: Skill) -> tuple[Outcome, Bench]:
    with Bench(tiny_world(), (outer(body), *others), (Step, Far, Hold, Arrive)) as bench:
        return bench.run("tour", **TO_A), bench


def test_a_skill_runs_within_another_with_renamed_and_inferred_parameters() -> None:
    inner = Skill(DRIVE_ANY, AssertEffects(0.01), driver="fake")

    outcome, bench = run_tour(Do.of("drive", Location=P("Location")), inner)

    assert isinstance(outcome, Success)
    told = [e for e in bench.events if e.module == "drive"]
    assert [e.status for e in told if e.status is not Status.RUNNING] == [Status.STARTED, Status.TERMINATED]
    assert {e.caller for e in told} == {"tour"}


DRIVE_ANY = replace(DRIVE, pre=(DRIVE.pre[0],))


def test_skills_that_call_each_other_for_ever_are_ended() -> None:
    outcome, _ = run_tour(Do.of("tour", Location=P("Location"), Base=P("Base"), Robot=P("Robot")))

    assert isinstance(outcome, Failure)
    assert "without end" in outcome.reason


@pytest.mark.parametrize("between", [lambda again: Fallback.of(again, Wait(0.1)), lambda again: Retry(again, 3)])
def test_a_run_that_calls_itself_for_ever_fails_for_that_reason_whatever_lies_between(between: Any) -> None:
    outcome, bench = run_tour(between(Do.of("tour", Location=P("Location"), Base=P("Base"), Robot=P("Robot"))))

    assert isinstance(outcome, Failure)
    assert outcome.reason.startswith("modules call each other without end: tour > tour")
    assert {e.status for e in bench.events if e.module == "tour"} >= {Status.STARTED, Status.ERROR}


def test_a_single_effect_can_be_asserted_by_name() -> None:
    post = (AT_LOCATION("Robot", "Location").named("there"),)
    body = Sequence.of(Wait(0.02), AssertEffects(0.0, only=("there",)))

    assert isinstance(outcome_of(body, description=replace(AFTER, post=post)), Success)


def test_an_effect_that_the_skill_does_not_have_is_refused_by_name() -> None:
    outcome = outcome_of(AssertEffects(0.0, only=("their",)))

    assert isinstance(outcome, Failure)
    assert "postcondition 'their'" in outcome.reason


# ---------------------------------------------------------------- as data

EVERY_NODE: Behaviour = Fallback.of(
    Sequence.of(step("a"), Wait(1.0), AssertEffects(1.0, only=("x",))),
    Parallel.of(Retry(step("b"), 2), Repeat(step("c"), 3), policy=Policy.ALL),
    Guard.of(Timeout(step("d"), 2.0), AT_LOCATION("Robot", "Location")),
    ForEach("Box", "tiny:Box", Check.of(AT_LOCATION("Robot", "Box")), Related("sk:in", "Ball", "Box")),
)


def test_every_node_is_printed_as_one_line_below_its_parent() -> None:
    shown = lines(EVERY_NODE)

    assert len(shown) == len(list(walk(EVERY_NODE)))
    assert shown[0] == "fallback"
    assert "  parallel, until all have ended" in shown
    assert "      d" not in shown
    assert any("for each Box of Box" in line for line in shown)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Retry(Wait(1.0), 0),
        lambda: Repeat(Wait(1.0), 0),
        lambda: Timeout(Wait(1.0), 0.0),
        lambda: Timeout(Wait(1.0), float("nan")),
        lambda: Wait(-1.0),
    ],
)
def test_invalid_numbers_in_nodes_are_refused(make: Any) -> None:
    with pytest.raises(DescriptionError):
        make()


def test_for_each_filters_elements_by_a_pattern_over_it() -> None:
    where_it_is = ForEach("Box", "tiny:Box", Do.of("arrive", place=P("Box")), Related("sk:at", "Robot", "it"))
    with bench_for(Sequence.of(ARRIVE, where_it_is)) as bench:
        bench.run("drive", **TO_A)
        places = [e.text for e in bench.events if e.module == "arrive" and e.status is Status.STARTED]

    assert places == ["place=box_a", "place=box_a"]


def test_a_child_at_a_lower_rate_is_ticked_once_per_period_and_keeps_its_outcome() -> None:
    assert ends_well(Every(0.05, step("slow", cycles=3))) == Success("")

    first, *later = cycles("slow")
    assert [cycle - first for cycle in later] == [10, 20]


def test_a_child_at_a_lower_rate_is_cancelled_at_once_and_recovers() -> None:
    outcome = outcome_of(Timeout(Every(0.05, step("slow", cycles=99)), 0.12))

    assert outcome == Failure("took longer than 0.12 s")
    assert texts()[-3:] == ["slow stops", "slow recovers", "slow recovers"]


def test_a_period_of_zero_or_less_is_refused() -> None:
    with pytest.raises(DescriptionError, match="a time above 0 s"):
        Every(0.0, step("x"))
