"""A run that takes much longer than usual is ended with a reason, and one that makes no progress is named."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf
from types import SimpleNamespace
from typing import Any, ClassVar

import pytest

from skiros_py.behaviours import AssertEffects, Do
from skiros_py.errors import DescriptionError
from skiros_py.execution.monitor import Status
from skiros_py.execution.time_limit import TimeLimit
from skiros_py.skills.context import QuestionKind
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import DRIVE


class Endless(Primitive[Any]):
    """Yields for ever."""

    name: ClassVar[str] = "endless"

    @dataclass(frozen=True, slots=True)
    class Params:
        """None."""

    def execute(self) -> Execution[Outcome]:
        yield from waiting()
        return Success()


def waiting() -> Iterator[None]:
    while True:
        yield


class Within(Endless):
    """Yields for ever, although it takes 0.1 s as a rule."""

    name = "within"
    duration = 0.1


class Strict(Endless):
    """Yields for ever, and has a limit of its own."""

    name = "strict"
    limit = 2.0


class Reports(Endless):
    """Goes on for long, and reports that."""

    name = "reports"

    def execute(self) -> Execution[Outcome]:
        for minute in range(14):
            self.progress(minute + 1, f"minute {minute}")
            end = self.context.now + 0.5
            while self.context.now < end:
                yield
        return Success("done")


class Patient(Within):
    """Takes its time, as its author said."""

    name = "patient"
    limit = inf

    def execute(self) -> Execution[Outcome]:
        while self.context.now < 5.0:
            yield
        return Success("done")


class Asks(Strict):
    """Asks a person, who takes long to answer."""

    name = "asks"

    def execute(self) -> Execution[Outcome]:
        asked = self.context.questions.ask(QuestionKind.CONFIRM, "Go on?", ("yes",), asker=self.name, time=0.0)
        while self.context.now < 5.0:
            yield
        self.context.questions.withdraw(asked)
        return Success("done")


ALL = [Endless, Within, Strict, Reports, Patient, Asks]


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    """Runs these modules with limits that are a hundredth of the usual ones."""
    for name, seconds in {"_LEAST": 3.0, "_STALLED": 0.6, "_LONGEST_STALL": 6.0}.items():
        monkeypatch.setattr(f"skiros_py.execution.time_limit.{name}", seconds)
    slow = Skill(replace(DRIVE, name="slow", limit=2.0), Do.of("endless"), driver="fake")
    late = Skill(replace(DRIVE, name="late", duration=1.0), Do.of("within"), driver="fake")
    with Bench(tiny_world(), [slow, late], ALL) as bench:
        yield bench


def reason(bench: Bench, module: str, **arguments: Any) -> str:
    outcome = bench.run(module, **arguments)
    assert isinstance(outcome, Failure)
    return outcome.reason


@pytest.mark.parametrize(
    ("duration", "limit", "over"),
    [(1.0, None, 300.0), (60.0, None, 1200.0), (60.0, 30.0, 30.0), (None, None, 600.0), (None, 5.0, 5.0)],
)
def test_a_run_may_take_twenty_times_its_duration_and_five_minutes_at_least_unless_its_author_says_otherwise(
    duration: float | None, limit: float | None, over: float
) -> None:
    context: Any = SimpleNamespace(now=0.0, questions=SimpleNamespace(open=()))
    watch = TimeLimit(context, duration, limit)

    context.now = over
    assert watch.why_over() == ""
    context.now = over + 1.0
    assert watch.why_over() != ""


def test_a_primitive_that_yields_for_ever_is_ended_and_the_reason_names_the_place_where_it_waits(bench: Bench) -> None:
    told = reason(bench, "within")

    assert told.startswith("within took longer than 3 s, 0.1 s are usual: it waits in waiting, ")
    assert __file__ in told
    assert bench.time == pytest.approx(3.0, abs=0.1)


def test_an_author_may_set_the_limit_or_lift_it(bench: Bench) -> None:
    assert reason(bench, "strict").startswith("strict took longer than 2 s")
    assert bench.run("patient") == Success("done")
    assert not [event for event in bench.events if event.module == "patient" and "no progress" in event.text]


def test_a_primitive_of_unknown_duration_is_ended_when_it_makes_no_progress_for_long(bench: Bench) -> None:
    assert reason(bench, "endless").startswith("endless made no progress for 6 s: it waits in waiting, ")
    assert bench.run("reports") == Success("done")


def test_a_stall_is_told_once_with_the_place_where_the_primitive_waits(
    bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    reason(bench, "within")

    told = [event for event in bench.events if "makes no progress" in event.text]
    assert [(event.module, event.status) for event in told] == [("within", Status.RUNNING)]
    assert told[0].time == pytest.approx(0.6, abs=0.1)
    assert "it waits in waiting, " in told[0].text
    assert caplog.text.count("within makes no progress") == 1


def test_the_time_in_which_a_person_is_asked_does_not_count(bench: Bench) -> None:
    assert bench.run("asks") == Success("done")


def test_the_question_of_another_run_does_not_stop_the_time(bench: Bench) -> None:
    bench.questions.ask(QuestionKind.CONFIRM, "Is the door open?", ("yes",), asker="another", time=0.0)

    assert reason(bench, "strict").startswith("strict took longer than 2 s")


def test_another_implementation_has_the_time_that_the_first_one_had() -> None:
    description = replace(DRIVE, name="slow", limit=2.0)
    first = Skill(description, Do.of("endless"), driver="fake", label="first")
    second = Skill(description, AssertEffects(), driver="fake", label="second")
    with Bench(tiny_world(), [first, second], [Endless]) as bench:
        assert bench.run("slow", Location="box_a") == Success("pretended")


@pytest.mark.parametrize(
    ("skill", "limit"), [("slow", "slow took longer than 2 s"), ("late", "within took longer than 3 s")]
)
def test_a_skill_has_a_limit_too_and_gives_its_devices_back(bench: Bench, skill: str, limit: str) -> None:
    assert reason(bench, skill, Location="box_a").startswith(limit)
    ended = [event.status for event in bench.events if event.module in ("endless", "within")]
    assert ended[-1] is (Status.PREEMPTED if skill == "slow" else Status.ERROR)
    assert reason(bench, "slow", Location="box_a").startswith("slow took longer than 2 s")


@pytest.mark.parametrize("limit", [0.0, -1.0, float("nan")])
def test_a_limit_that_is_no_time_is_refused(limit: float) -> None:
    with pytest.raises(DescriptionError, match="limit"):
        replace(DRIVE, limit=limit)
    with pytest.raises(DescriptionError, match="limit"):
        type("Wrong", (Endless,), {"limit": limit})
