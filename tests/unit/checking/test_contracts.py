from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import pytest
from support.battery import battery_world, driving

from skiros_py.behaviours import AssertEffects, Do, P, Sequence
from skiros_py.checking.cases import Ground
from skiros_py.checking.contract import check_contract
from skiros_py.skills.conditions import Compare, Computed, ConditionType, Related, Role, Verdict
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, Param, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill
from skiros_py.testing import SKILLS, tiny_world
from skiros_py.testing.contract import check_contract as assert_contract
from skiros_py.testing.contract import contract_cases
from skiros_py.testing.tiny import DRIVE, PICK, PLACE, pretend

TINY = [Ground("tiny", tiny_world)]


class Meddle(Primitive["Meddle.Params"]):
    """Does something to the world, and one thing more."""

    name: ClassVar[str] = "meddle"
    write: ClassVar[Callable[[Any, Meddle.Params], None]] = lambda _tx, _params: None

    @dataclass(frozen=True, slots=True)
    class Params:
        robot: str = param("sk:Robot", "The robot.", kind=Kind.PLANNING)
        place: str = param("sk:Location", "The place.")

    def execute(self) -> Execution[Outcome]:
        yield
        with self.world.transaction(self.name, "meddles") as tx:
            type(self).write(tx, self.params)
        return Success()


def meddling(write: Callable[[Any, Meddle.Params], None]) -> type[Meddle]:
    return type("Meddling", (Meddle,), {"write": staticmethod(write)})


def rules_and_texts(skill: Skill, *primitives: type[Primitive[Any]]) -> list[tuple[str, str]]:
    named = {primitive.name: primitive for primitive in primitives}
    return [(f.rule, f.text) for f in check_contract(skill, TINY, SKILLS, named).findings]


DRIVE_AND_MEDDLE = pretend(
    DRIVE, Sequence.of(AssertEffects(0.02), Do.of("meddle", robot=P("Robot"), place=P("Location")))
)


@pytest.mark.parametrize("skill", SKILLS, ids=lambda s: s.description.name)
def test_skills_that_do_what_they_declare_pass(skill: Skill) -> None:
    contract = check_contract(skill, TINY, SKILLS)

    assert contract.findings == ()
    assert isinstance(contract.outcome, Success)


def test_a_skill_whose_preconditions_hold_in_the_scene_runs_there() -> None:
    assert check_contract(pretend(DRIVE), TINY).where == "tiny"


def test_missing_preconditions_are_established_by_other_skills() -> None:
    contract = check_contract(pretend(PLACE), TINY, SKILLS)

    assert contract.where == "tiny, after other skills"
    assert contract.arguments is not None
    assert contract.arguments["Ball"] == "ball_1"


def test_preconditions_that_no_skill_achieves_are_written_into_the_world() -> None:
    contract = check_contract(pretend(PICK), TINY)

    assert (contract.where, contract.findings) == ("tiny, made up", ())


def test_an_effect_that_did_not_happen_is_named_with_the_reason() -> None:
    idle = pretend(DRIVE, Do.of("meddle", robot=P("Robot"), place=P("Location")))

    ((rule, text),) = rules_and_texts(idle, Meddle)

    assert rule == "effect-missing"
    assert text.startswith("At(robot_1, ")
    assert "it is at unknown_location" in text


def test_the_failure_reason_of_a_skill_is_reported_with_the_missing_effects() -> None:
    class Refuse(Meddle):
        name: ClassVar[str] = "refuse"

        def execute(self) -> Execution[Outcome]:
            yield
            return Failure("the wheels are gone")

    ((rule, text),) = rules_and_texts(pretend(DRIVE, Do.of("refuse", robot=P("Robot"), place=P("Location"))), Refuse)

    assert rule == "effect-missing"
    assert "the wheels are gone" in text


@pytest.mark.parametrize(
    ("write", "said"),
    [
        (lambda tx, p: tx.relate(p.robot, "tiny:knows", p.place), "tiny:knows"),
        (lambda tx, p: tx.set(p.place, "sk:missing", True), "sk:missing"),
        (lambda tx, _: tx.place("ball_1", "sk:in", "box_b"), "ball_1"),
        (lambda tx, _: tx.remove("ball_1"), "ball_1 (tiny:Ball)"),
        (lambda tx, _: tx.set_goals(["Free(slot_1)"]), "goal"),
    ],
    ids=["relation", "property", "place", "element", "goals"],
)
def test_a_change_that_is_not_declared_is_named(write: Callable[[Any, Meddle.Params], None], said: str) -> None:
    ((rule, text),) = rules_and_texts(DRIVE_AND_MEDDLE, meddling(write))

    assert rule == "undeclared-change"
    assert said in text


def test_an_undeclared_new_element_is_one_finding_whatever_its_properties() -> None:
    def write(tx: Any, _params: Meddle.Params) -> None:
        ball = tx.add("tiny:Ball")
        tx.place(ball, "sk:in", "box_a")
        tx.set(ball, "sk:missing", True)

    assert [rule for rule, _ in rules_and_texts(DRIVE_AND_MEDDLE, meddling(write))] == ["undeclared-change"]


def test_poses_of_a_moved_thing_and_of_its_parts_need_not_be_declared() -> None:
    from skiros_py.geometry import Pose

    def write(tx: Any, params: Meddle.Params) -> None:
        tx.set("base_1", "sk:pose", Pose.of(1.0, 2.0, 0.0))
        tx.set(params.robot, "sk:pose", Pose.of(1.0, 2.0, 0.0))

    assert rules_and_texts(DRIVE_AND_MEDDLE, meddling(write)) == []


def test_an_undeclared_pose_change_of_an_unmoved_thing_is_found() -> None:
    from skiros_py.geometry import Pose

    def write(tx: Any, _params: Meddle.Params) -> None:
        tx.set("ball_1", "sk:pose", Pose.of(1.0, 2.0, 0.0))

    assert [rule for rule, _ in rules_and_texts(DRIVE_AND_MEDDLE, meddling(write))] == ["undeclared-change"]


def test_only_declared_values_may_change() -> None:
    missing = ConditionType("Lost", (Role("place", "sk:Location"),), Compare("sk:missing", "=", "place", True), "Lost.")
    lose = pretend(replace(DRIVE, post=(*DRIVE.post, missing("Location"))), DRIVE_AND_MEDDLE.body)

    assert rules_and_texts(lose, Meddle) == []


def test_a_skill_that_can_never_start_is_reported_with_what_is_missing() -> None:
    never = Computed("tiny:fitsIn", "a", "b", lambda *_: Verdict(False, "the stars stand badly"))
    lucky = ConditionType("Lucky", (Role("a", "sk:Robot"), Role("b", "sk:Location")), never, "Luck.")
    skill = pretend(replace(DRIVE, pre=(*DRIVE.pre, lucky("Robot", "Location"))))

    ((rule, text),) = rules_and_texts(skill)

    assert rule == "never-tried"
    assert "the stars stand badly" in text


def test_parameters_without_a_value_get_an_example_value() -> None:
    slow = replace(DRIVE, params=(*DRIVE.params, Param("Speed", "number", "How fast.", unit="m/s")))

    contract = check_contract(pretend(slow), TINY)

    assert contract.findings == ()
    assert contract.arguments is not None
    assert contract.arguments["Speed"] == 1.0


def test_a_skill_that_never_ends_is_cancelled() -> None:
    class Sleep(Meddle):
        name: ClassVar[str] = "snooze"

        def execute(self) -> Execution[Outcome]:
            while True:
                yield

    ((rule, text),) = rules_and_texts(pretend(DRIVE, Do.of("snooze", robot=P("Robot"), place=P("Location"))), Sleep)

    assert rule == "effect-missing"
    assert "did not end" in text


def test_a_case_refused_by_the_world_is_used_only_without_an_alternative() -> None:
    nested = ConditionType(
        "Inside", (Role("a", "tiny:Box"), Role("b", "sk:Location")), Related("sk:in", "a", "b"), "In."
    )
    own = (Param("Box", "tiny:Box", "What."), Param("Into", "tiny:Box", "Where to."))
    params = (*DRIVE.params[:2], *own)
    pack = replace(DRIVE, params=params, target="Into", pre=DRIVE.pre[:1], post=(nested("Box", "Into"),))

    contract = check_contract(pretend(pack), TINY)

    assert contract.findings == ()
    assert contract.arguments is not None
    assert contract.arguments["Box"] != contract.arguments["Into"]


def test_an_author_asserts_a_contract_of_one_skill() -> None:
    assert_contract(pretend(PICK), tiny_world, skills=SKILLS)
    idle = pretend(DRIVE, Do.of("meddle", robot=P("Robot"), place=P("Location")))

    with pytest.raises(AssertionError, match="effect-missing"):
        assert_contract(idle, tiny_world, primitives=[Meddle])


@pytest.mark.parametrize("case", contract_cases("skiros-skills"), ids=str)
def test_the_built_in_skills_do_what_they_declare(case: Any) -> None:
    case.check()


def test_a_condition_that_raises_is_a_finding() -> None:
    def broken(*_: object) -> Verdict:
        raise ZeroDivisionError("no such luck")

    word = ConditionType(
        "Odd", (Role("a", "sk:Robot"), Role("b", "sk:Location")), Computed("tiny:fitsIn", "a", "b", broken), "Odd."
    )

    ((rule, text),) = rules_and_texts(pretend(replace(DRIVE, pre=(*DRIVE.pre, word("Robot", "Location")))))

    assert rule in ("effect-missing", "never-tried")
    assert "no such luck" in text


def odd(function: Callable[..., Verdict]) -> Any:
    pattern = Computed("tiny:fitsIn", "a", "b", function)
    return ConditionType("Odd", (Role("a", "sk:Robot"), Role("b", "sk:Location")), pattern, "Odd.")("Robot", "Location")


def of_conditions(overrun: float | None = None, **conditions: Any) -> list[tuple[str, str]]:
    skill = pretend(replace(DRIVE, **{key: (*getattr(DRIVE, key), odd(value)) for key, value in conditions.items()}))
    return [(f.rule, f.text) for f in check_contract(skill, TINY, overrun=overrun).findings]


@pytest.mark.parametrize("key", ["pre", "hold"])
def test_a_condition_that_raises_system_exit_is_a_finding(key: str) -> None:
    def leave(*_: object) -> Verdict:
        sys.exit(3)

    ((rule, text),) = of_conditions(**{key: leave})

    assert rule == "effect-missing"
    assert "it tried to end the program: sys.exit(3)" in text


@pytest.mark.parametrize("key", ["pre", "hold"])
def test_a_condition_that_hangs_is_a_finding(key: str) -> None:
    def hog(*_: object) -> Verdict:
        while True:
            pass

    ((rule, text),) = of_conditions(overrun=0.2, **{key: hog})

    assert rule == "effect-missing"
    assert "a condition held the control cycle too long" in text


def test_a_primitive_that_hangs_is_a_finding() -> None:
    class Hog(Meddle):
        name: ClassVar[str] = "hog"

        def execute(self) -> Execution[Outcome]:
            yield
            while True:
                pass

    skill = pretend(DRIVE, Do.of("hog", robot=P("Robot"), place=P("Location")))

    ((rule, text),) = [(f.rule, f.text) for f in check_contract(skill, TINY, (), {"hog": Hog}, overrun=0.2).findings]

    assert rule == "effect-missing"
    assert "hog (of" in text
    assert "held the control cycle" in text


def test_no_watchdog_thread_stays_behind() -> None:
    check_contract(pretend(PLACE), TINY, SKILLS)

    assert not [thread for thread in threading.enumerate() if thread.name == "skiros-watchdog"]


CHARGED_WORLD = [Ground("charged", lambda: battery_world(50.0))]


def test_a_skill_that_lowers_a_number_as_it_declares_passes_where_nothing_asks_for_the_number() -> None:
    skill = pretend(replace(DRIVE, post=driving().post))

    assert check_contract(skill, CHARGED_WORLD).findings == ()
    assert check_contract(skill, TINY).findings == (), "the robot is given a charge"


@pytest.mark.parametrize("change", [0.0, 10.0])
def test_a_number_that_goes_another_way_than_declared_is_named(change: float) -> None:
    def write(tx: Any, params: Meddle.Params) -> None:
        tx.place(params.robot, "sk:at", params.place)
        tx.set(params.robot, "tiny:charge", 50.0 + change)

    body = Do.of("meddle", robot=P("Robot"), place=P("Location"))
    contract = check_contract(pretend(driving(), body), CHARGED_WORLD, (), {"meddle": meddling(write)})

    assert [(f.rule, f.text.partition(" (")[0]) for f in contract.findings] == [
        ("effect-missing", f"tiny:charge of robot_1 was 50 and is {50 + change:g}")
    ]
