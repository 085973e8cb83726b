"""Conditions that break, commands and calls that make no sense: the fault is that of the module, in words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import pytest

from skiros_py.behaviours import Do, P
from skiros_py.devices.mobile_base import Base, BaseState, BaseTwist
from skiros_py.errors import DescriptionError, SkirosError, UnknownName
from skiros_py.ports.cell import CellSpec
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.conditions import Computed, ConditionType, Role
from skiros_py.skills.context import QuestionKind
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.testing import (
    Bench,
    FaultyCell,
    Frozen,
    answers,
    run_primitive,
    run_skill,
    tiny_world,
)
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, PICK, PLACE, REACHABLE, pretend

from .bad import Bad, Behaviour, Moving, assert_others_go_on, bad, yielding

# ------------------------------------------------------------------ conditions


def breaks(view: Any, ball: str, slot: str) -> Any:
    raise ValueError("no such shape")


def knows_nothing(view: Any, ball: str, slot: str) -> Any:
    return None


def demanding(evaluate: Any, when: str) -> SkillDescription:
    """A skill with a condition of somebody's own Python, before or during it."""
    roles = (Role("ball", "tiny:Ball"), Role("slot", "tiny:Slot"))
    shaped = ConditionType("Shaped", roles, Computed("tiny:fitsIn", "ball", "slot", evaluate), "-")
    description = replace(PLACE, pre=())
    return replace(description, **{when: (*getattr(description, when), shaped("Ball", "Slot"))})


@pytest.mark.parametrize("when", ["pre", "hold"])
@pytest.mark.parametrize(("evaluate", "told"), [(breaks, "no such shape"), (knows_nothing, "None")])
def test_a_condition_that_raises_fails_only_its_skill(evaluate: Any, told: str, when: str) -> None:
    with Bench(tiny_world(), (pretend(demanding(evaluate, when)), pretend(DRIVE))) as bench:
        outcome = bench.run("place", Ball="ball_1", Slot="slot_1")

        assert isinstance(outcome, Failure)
        assert told in outcome.reason
        assert bench.run("drive", Location="box_a") == Success("pretended")


def test_a_condition_that_raises_during_planning_is_reported_by_name() -> None:
    description = replace(demanding(breaks, "pre"), pre=(*PLACE.pre, *demanding(breaks, "pre").pre))
    with (
        Bench(tiny_world(), (pretend(description), pretend(PICK), pretend(DRIVE))) as bench,
        pytest.raises(SkirosError, match="Shaped"),
    ):
        bench.pursue("In(ball_1, slot_1)")


# ------------------------------------------------------------------ what they reach


def commands_nobody(bad: Bad) -> Execution[Outcome]:
    bad.context.board.send("nobody", BaseTwist(0.0, 0.0))
    yield
    return Success("as if nothing were")


def commands_nonsense(bad: Bad) -> Execution[Outcome]:
    bad.context.board.send("base_1", "fast")
    yield
    return Success("as if nothing were")


def commands_no_number(bad: Bad) -> Execution[Outcome]:
    Base(bad.context.board, "base_1").command(BaseTwist(float("nan"), 0.0))
    yield
    return Success("as if nothing were")


@pytest.mark.parametrize("behaviour", [commands_nobody, commands_nonsense, commands_no_number])
def test_an_invalid_command_fails_its_module_but_not_the_cell(behaviour: Behaviour) -> None:
    with Bench(tiny_world(), (), [bad(behaviour), Moving]) as bench:
        assert isinstance(bench.run("bad", base="base_1"), Failure)
        assert_others_go_on(bench)


def commands_others(bad: Bad) -> Execution[Outcome]:
    for _ in range(20):
        Base(bad.context.board, "base_2").command(BaseTwist(0.5, 0.0))
        yield
    return Success("as if nothing were")


def test_a_module_does_not_move_a_device_that_it_has_not_taken() -> None:
    with Bench(tiny_world(robots=2), (), [bad(commands_others), Moving]) as bench:
        before = bench.cycle.board.snapshot.state("base_2", BaseState).pose
        outcome = bench.run("bad", base="base_1")

        assert isinstance(outcome, Failure)
        assert "base_2" in outcome.reason
        assert bench.cycle.board.snapshot.state("base_2", BaseState).pose == before


def keeps_a_transaction_open(bad: Bad) -> Execution[Outcome]:
    with bad.world.transaction("bad", "takes its time") as tx:
        tx.place("ball_1", "sk:in", "box_b")
        while True:
            yield


def test_a_transaction_left_open_by_a_stopped_module_changes_nothing_and_does_not_block_writers() -> None:
    with Bench(tiny_world(), (pretend(DRIVE),), [bad(keeps_a_transaction_open)]) as bench:
        running = bench.start("bad", base="base_1")
        bench.advance(0.3)
        running.stop()
        bench.until(lambda: running.done, limit=1.0)

        assert bench.world.objects("ball_1", "sk:in") == ("box_a",)
        assert bench.run("drive", Location="box_a") == Success("pretended")


def calls_itself(bad: Bad) -> Execution[Outcome]:
    return (yield from bad.call("bad", base="base_1"))


def calls_nobody(bad: Bad) -> Execution[Outcome]:
    return (yield from bad.call("nobody"))


def joins_nonsense(bad: Bad) -> Execution[Outcome]:
    yield from bad.join(5)  # type: ignore[arg-type]  # the nonsense that is tried
    return Success("as if nothing were")


def forgets_yield_from(bad: Bad) -> Execution[Any]:
    yield
    return bad.call("moving", base="base_1")


@pytest.mark.parametrize("behaviour", [calls_itself, calls_nobody, joins_nonsense, forgets_yield_from])
def test_an_invalid_call_fails_its_module(behaviour: Behaviour) -> None:
    with Bench(tiny_world(), (), [bad(behaviour), Moving]) as bench:
        outcome = bench.run("bad", base="base_1")

        assert isinstance(outcome, Failure)
        assert outcome.reason.startswith("bad")
        assert_others_go_on(bench)


def asks(bad: Bad) -> Execution[Outcome]:
    question = bad.context.questions.ask(QuestionKind.CONFIRM, "Well?", ("yes",), asker="bad", time=0.0)
    while question.answer is None:
        yield
    return Success(question.answer)


def test_listeners_that_raise_affect_neither_the_question_nor_other_listeners() -> None:
    def breaks(heard: Any) -> None:
        raise ValueError("cannot listen")

    with Bench(tiny_world(), (), [bad(asks), Moving]) as bench:
        bench.monitor.subscribe(breaks)
        bench.questions.subscribe(breaks)
        answers(bench.questions, {"Well": "yes"})

        assert bench.run("bad", base="base_1") == Success("yes")


def test_a_device_that_never_reports_standstill_is_reported_and_not_waited_for_forever() -> None:
    def cell(spec: CellSpec) -> FaultyCell:
        return FaultyCell(FakeCell(spec), Frozen("base_1", after=0.05))

    with Bench(tiny_world(), (), [bad(yielding(None))], cell=cell) as bench:
        running = bench.start("bad", base="base_1")
        bench.advance(0.3)
        running.stop()

        bench.until(lambda: running.done, limit=5.0)
        assert "base_1" in str(running.result)


# ------------------------------------------------------------------ parameters


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"Ball": "box_a"}, ("Ball", "box_a", "tiny:Ball")),
        ({"Ball": "nobody"}, ("nobody",)),
        ({"Ball": "tiny:Ball"}, ("Ball",)),
        ({"Ball": 5}, ("Ball", "5")),
        ({"Ball": "ball_1", "Bal": "ball_1"}, ("Bal",)),
        ({"Ball": "ball_1", "Arm": "base_1"}, ("Arm", "base_1")),
    ],
    ids=str,
)
def test_a_skill_with_bad_parameters_does_not_start_and_names_them(
    arguments: Mapping[str, Any], told: tuple[str, ...]
) -> None:
    trial = run_skill(pretend(replace(PICK, pre=())), tiny_world(), **arguments)

    assert not trial
    assert "pick" in trial.reason
    assert all(words in trial.reason for words in told), trial.reason
    assert trial.changes == ()


def test_a_primitive_without_required_parameters_names_the_missing_ones() -> None:
    trial = run_primitive(Needy, tiny_world())

    assert not trial
    assert "needy" in trial.reason
    assert "place" in trial.reason
    assert "much" in trial.reason
    assert "base" not in trial.reason.replace("needy", "")


class Needy(Moving):
    """Needs much."""

    name = "needy"

    @dataclass(frozen=True, slots=True)
    class Params:
        base: str = param("sk:Base", "The base.", kind=Kind.HARDWARE)
        place: str = param("sk:Location", "Where to.")
        much: float = param("number", "How much.", unit="m")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"place": "box_a", "much": "a lot"}, ("much", "a lot")),
        ({"place": "box_a", "much": float("nan")}, ("much",)),
        ({"place": "ball_1", "much": 1.0}, ("place", "ball_1")),
        ({"place": "box_a", "much": 1.0, "more": 2.0}, ("more",)),
        ({"place": "box_a", "much": 1.0, "base": "arm_1"}, ("base", "arm_1")),
    ],
    ids=str,
)
def test_a_primitive_with_bad_parameters_does_not_start(arguments: Mapping[str, Any], told: tuple[str, ...]) -> None:
    trial = run_primitive(Needy, tiny_world(), **arguments)

    assert not trial
    assert "needy" in trial.reason
    assert all(words in trial.reason for words in told), trial.reason
    assert trial.seconds < 0.1


def test_a_module_without_a_provider_is_unknown() -> None:
    with Bench(tiny_world()) as bench, pytest.raises(UnknownName, match="Did you mean 'drive'"):
        bench.run("drove")


def test_a_skill_that_calls_a_missing_module_fails_and_names_it() -> None:
    trial = run_skill(Skill(DRIVE, Do.of("paddle")), tiny_world(), Location="box_a")

    assert "paddle" in trial.reason


def test_endlessly_recursive_skill_calls_are_ended() -> None:
    hop = replace(DRIVE, name="hop")
    there, back = Skill(DRIVE, Do.of("hop", Location=P("Location"))), Skill(hop, Do.of("drive", Location=P("Location")))

    trial = run_skill(there, tiny_world(), skills=[back], Location="box_a")

    assert "without end" in trial.reason


# ------------------------------------------------------------------ descriptions


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"name": ""}, "name"),
        ({"post": ()}, "postcondition"),
        ({"pre": (REACHABLE("Elsewhere"),)}, "Elsewhere"),
        ({"agent": "Nobody"}, "Nobody"),
        ({"target": "Nothing"}, "Nothing"),
    ],
    ids=str,
)
def test_an_invalid_description_is_refused_at_its_definition(change: dict[str, Any], told: str) -> None:
    with pytest.raises((DescriptionError, UnknownName), match=told):
        replace(DRIVE, **change)


def test_two_parameters_with_the_same_key_are_refused() -> None:
    with pytest.raises(DescriptionError, match="Base"):
        SkillDescription(
            "drive", "-", "Base", "Base", (*DRIVE.params[:1], *DRIVE.params), post=(AT_LOCATION("Robot", "Location"),)
        )
