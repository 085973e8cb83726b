"""A skill's run, phase by phase: parameters, implementations, conditions, effects, and being cancelled in each."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import pytest

from skiros_py.behaviours import AssertEffects, Behaviour, Check, Do, Fallback, Guard, P, Sequence
from skiros_py.devices.gripper import Gripper, GripperState, GripperTarget
from skiros_py.execution.monitor import Status
from skiros_py.skills.conditions import Computed, ConditionType, Expression, Related, Role, Verdict
from skiros_py.skills.outcome import CANCELLED, Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, Param, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, EMPTY_HANDED, HAS_PART, REACHABLE
from skiros_py.world.view import WorldView
from skiros_py.world.world import World

lived: list[tuple[str, int]] = []
AFTER = replace(DRIVE, pre=())
GRIPPER = Param("Gripper", "sk:Gripper", "Its gripper.", Kind.HARDWARE)
ROBOT = Role("robot", "sk:Robot")
WHOLE = HAS_PART("Robot", "Base")


@pytest.fixture(autouse=True)
def _fresh() -> None:
    lived.clear()


class Note(Primitive["Note.Params"]):
    """Writes down when it runs, and does as told."""

    name: ClassVar[str] = "note"

    @dataclass(frozen=True, slots=True)
    class Params:
        text: str = param("text", "What to write.")
        cycles: int = param("integer", "How many cycles to run.", kind=Kind.OFFLINE, default=1)
        ends: str = param("text", "'well', or why it fails.", kind=Kind.OFFLINE, default="well")
        goes: str = param("text", "Where the robot is afterwards.", kind=Kind.OFFLINE, default="")

    def execute(self) -> Execution[Outcome]:
        for _ in range(self.params.cycles):
            lived.append((self.params.text, self.context.board.snapshot.cycle))
            yield
        if self.params.goes:
            with self.world.transaction("note", "arrived") as tx:
                tx.place("robot_1", "sk:at", self.params.goes)
        return Success() if self.params.ends == "well" else Failure(self.params.ends)

    def recover(self) -> Execution[None]:
        lived.append((f"{self.params.text} recovers", self.context.board.snapshot.cycle))
        yield


def note(text: str, **more: Any) -> Do:
    return Do.of("note", text=text, **more)


def way(body: Behaviour, description: SkillDescription = AFTER, **more: Any) -> Skill:
    return Skill(description, body, driver="fake", **more)


def bench_of(*ways: Skill, world: World | None = None) -> Bench:
    return Bench(world or tiny_world(), ways, (Note, Squeeze, Sense))


def run(*ways: Skill, world: World | None = None, **arguments: Any) -> Outcome:
    with bench_of(*ways, world=world) as bench:
        return bench.run("drive", **{"Location": "box_a", **arguments})


def texts() -> list[str]:
    return [text for text, _ in lived]


class Squeeze(Primitive["Squeeze.Params"]):
    """Closes a gripper a little more in each cycle."""

    name: ClassVar[str] = "squeeze"

    @dataclass(frozen=True, slots=True)
    class Params:
        gripper: str = param("sk:Gripper", "The gripper.", kind=Kind.HARDWARE)

    def execute(self) -> Execution[Outcome]:
        gripper = Gripper(self.context.board, self.params.gripper)
        while True:
            gripper.command(GripperTarget(max(0.0, gripper.state.gap - 0.001), 5.0))
            yield


class Sense(Primitive["Sense.Params"]):
    """Asserts effects of its skill by their keys."""

    name: ClassVar[str] = "sense"

    @dataclass(frozen=True, slots=True)
    class Params:
        keys: tuple[str, ...] = param("text", "Which.", length=0)

    def execute(self) -> Execution[Outcome]:
        yield
        self.assert_effects(*self.params.keys, reason="saw it")
        return Success()


# ------------------------------------------------------------------ order


def test_phases_run_in_order_each_in_the_cycle_after_the_previous_one() -> None:
    skill = way(
        note("body", goes="box_a"),
        pre_sense=note("before"),
        finish=note("finish"),
        post_sense=note("after"),
    )

    assert isinstance(run(skill), Success)
    assert texts() == ["before", "body", "finish", "after"]
    cycles = [cycle for _, cycle in lived]
    assert cycles == [cycles[0] + 2 * number for number in range(4)]


def test_a_postcondition_may_be_established_by_post_sensing() -> None:
    assert isinstance(run(way(note("body"), post_sense=note("after", goes="box_a"))), Success)


def test_post_sensing_is_skipped_after_a_failing_body() -> None:
    assert run(way(note("body", ends="slipped"), finish=note("finish"), post_sense=note("after"))) == Failure("slipped")
    assert texts() == ["body", "finish"]


# ------------------------------------------------------------------ implementations


def test_the_implementation_of_the_lowest_order_is_tried_first_then_by_label() -> None:
    last, second, first = (
        way(note(label, goes="box_a" if label == "c" else ""), order=order, label=label)
        for label, order in (("c", 1), ("b", 0), ("a", 0))
    )

    assert isinstance(run(last, second, first), Success)
    assert texts() == ["a", "b", "c"]


def test_a_failed_implementation_is_followed_by_the_next_and_an_event_says_so() -> None:
    with bench_of(way(note("a", ends="slipped"), label="a"), way(note("b", goes="box_a"), label="b")) as bench:
        assert isinstance(bench.run("drive", Location="box_a"), Success)

        assert "slipped; trying b" in [event.text for event in bench.events if event.module == "drive"]


def test_when_all_implementations_fail_the_reasons_of_all_are_given() -> None:
    assert run(way(note("a", ends="slipped"), label="a"), way(note("b", ends="stuck"), label="b")) == Failure(
        "slipped; stuck"
    )


def test_an_implementation_whose_own_condition_fails_is_skipped() -> None:
    near = way(note("near", goes="box_a"), label="a", when=(AT_LOCATION("Robot", "Location"),))
    far = way(note("far", goes="box_a"), label="b")

    assert isinstance(run(near, far), Success)
    assert texts() == ["far"]


def test_an_implementation_whose_hardware_the_robot_lacks_is_not_offered() -> None:
    seeing = way(note("seeing"), label="a", requires=("sk:Camera",))
    blind = way(note("blind", goes="box_a"), label="b", requires=("sk:Gripper",))

    with bench_of(seeing, blind) as bench:
        assert [skill.label for skill in bench.managers["base_1"].skills["drive"]] == ["b"]
        assert isinstance(bench.run("drive", Location="box_a"), Success)
    assert texts() == ["blind"]


def test_a_skill_all_of_whose_implementations_need_other_hardware_is_not_offered_at_all() -> None:
    with bench_of(way(note("seeing"), requires=("sk:Camera",))) as bench:
        assert "drive" not in bench.managers["base_1"].descriptions


def test_the_next_implementation_is_not_tried_if_the_preconditions_no_longer_hold() -> None:
    needs = replace(AFTER, pre=(AT_LOCATION("Robot", "Location"),))
    world = tiny_world()
    with world.transaction("test", "is there") as tx:
        tx.place("robot_1", "sk:at", "box_a")

    outcome = run(
        way(note("a", goes="floor", ends="slipped away"), needs, label="a"),
        way(note("b"), needs, label="b"),
        world=world,
    )

    assert outcome == Failure("slipped away")
    assert texts() == ["a"]


def test_after_a_cancel_no_other_implementation_is_tried() -> None:
    with bench_of(way(note("a", cycles=99), label="a"), way(note("b"), label="b")) as bench:
        outcome = bench.run("drive", Location="box_a", cancel=lambda: "the plan changed" if lived else "")

    assert outcome == Failure("the plan changed", CANCELLED)
    assert texts() == ["a", "a recovers"]


# ------------------------------------------------------------------ cancelled in any phase


@pytest.mark.parametrize(
    ("phase", "follows"),
    [
        ("before", ["before", "before recovers"]),
        ("body", ["before", "body", "body recovers", "finish"]),
        ("after", ["before", "body", "finish", "after", "after recovers"]),
    ],
)
def test_a_cancel_ends_the_current_phase_at_once_and_runs_only_the_required_later_phases(
    phase: str, follows: list[str]
) -> None:
    long = {"before": 1, "body": 1, "after": 1, phase: 999}
    skill = way(
        note("body", cycles=long["body"]),
        pre_sense=note("before", cycles=long["before"]),
        finish=note("finish"),
        post_sense=note("after", cycles=long["after"]),
    )
    with bench_of(skill) as bench:
        running = bench.start("drive", Location="box_a")
        bench.until(lambda: phase in texts())
        running.cancel("the plan changed")
        bench.until(lambda: running.done, limit=0.1)

    assert running.result == Failure("the plan changed", CANCELLED)
    assert list(dict.fromkeys(texts())) == follows


def test_a_finish_runs_to_completion_even_if_cancelled() -> None:
    with bench_of(way(note("body", goes="box_a"), finish=note("finish", cycles=9))) as bench:
        running = bench.start("drive", Location="box_a")
        bench.until(lambda: "finish" in texts())
        running.cancel("the plan changed")
        bench.until(lambda: running.done)

    assert texts().count("finish") == 9


def test_a_run_waiting_for_its_devices_is_cancelled_at_once() -> None:
    with bench_of(way(note("body"))) as bench:
        claim = bench.managers.claims.request("somebody", ["base_1"])
        running = bench.start("drive", Location="box_a")
        bench.advance(0.1)
        assert bench.events[-1].text == "waits for base_1 (somebody)"
        running.cancel("the plan changed")
        bench.advance(0.02)

        assert running.result == Failure("the plan changed", CANCELLED)
        claim.release()
    assert lived == []


# ------------------------------------------------------------------ hold conditions


OPEN = ConditionType("Open", (Role("gripper", "sk:Gripper"),), Expression("gripper.gap > 0.03"), "Its gap is wide.")


def with_gripper(**more: Any) -> SkillDescription:
    return replace(AFTER, params=(*AFTER.params, GRIPPER), **more)


def test_a_hold_condition_on_a_sensor_ends_the_body_in_the_cycle_that_says_so() -> None:
    with bench_of(way(Do.of("squeeze", gripper=P("Gripper")), with_gripper(hold=(OPEN("Gripper"),)))) as bench:
        outcome = bench.run("drive", Location="box_a", Gripper="gripper_1")

        assert isinstance(outcome, Failure)
        assert outcome.reason.startswith("hold condition Open(gripper_1): ")
        assert bench.cycle.board.snapshot.state("gripper_1", GripperState).gap == pytest.approx(0.03, abs=0.0015)


def test_a_hold_condition_is_checked_only_while_the_body_runs() -> None:
    skill = way(
        note("body", cycles=3),
        replace(AFTER, hold=(AT_LOCATION("Robot", "Location"),), post=(WHOLE,)),
        pre_sense=note("before", goes="box_a"),
        finish=note("finish", goes="floor"),
        post_sense=note("after"),
    )

    assert isinstance(run(skill), Success)


# ------------------------------------------------------------------ effects


def held_and_at(*keys: str) -> tuple[Skill, World]:
    description = replace(
        AFTER,
        params=(*AFTER.params, GRIPPER),
        post=(AT_LOCATION("Robot", "Location").named("there"), EMPTY_HANDED("Gripper")),
    )
    return way(Do.of("sense", keys=keys), description), tiny_world()


def test_a_primitive_asserts_an_effect_of_its_skill_by_key_and_with_its_reason() -> None:
    skill, world = held_and_at("there")

    assert isinstance(run(skill, world=world, Gripper="gripper_1"), Success)
    assert (world.changes[-1].author, world.changes[-1].reason) == ("sense", "saw it")


def test_an_unknown_effect_name_is_refused_with_the_known_ones() -> None:
    skill, world = held_and_at("their")
    before = world.version

    outcome = run(skill, world=world, Gripper="gripper_1")
    assert isinstance(outcome, Failure)
    assert "unknown postcondition 'their'. Did you mean 'there'?" in outcome.reason
    assert not world.related("robot_1", "sk:at", "box_a")
    assert all(change.author != "sense" for change in world.changes_since(before))


def test_a_primitive_that_runs_by_itself_has_no_effects_to_assert() -> None:
    with bench_of() as bench:
        assert bench.run("sense", keys=("there",)) == Success()


def test_a_called_skill_asserts_its_own_effects() -> None:
    inner = Skill(replace(AFTER, name="inner"), Do.of("sense", keys=()), driver="fake")
    outer = way(Do.of("inner", Location="box_b"), replace(AFTER, post=(~AT_LOCATION("Robot", "Location"),)))

    with Bench(tiny_world(), (inner, outer), (Sense,)) as bench:
        assert isinstance(bench.run("drive", Location="box_a"), Success)
        assert bench.world.related("robot_1", "sk:at", "box_b")


# ------------------------------------------------------------------ parameters


def test_omitted_parameters_are_inferred_at_each_start() -> None:
    described = replace(AFTER.param("Location"), type="tiny:Ball", where=(Related("sk:in", "it", "Box"),))
    box = Param("Box", "tiny:Box", "Out of which.")
    params = tuple(described if p.key == "Location" else p for p in AFTER.params)
    skill = way(note(P("Location")), replace(AFTER, params=(*params, box), post=(WHOLE,)))
    with bench_of(skill) as bench:
        bench.run("drive", Location=None, Box="box_b")
        with bench.world.transaction("test", "swaps them") as tx:
            tx.place("red_ball_1", "sk:in", "box_a")
            tx.place("ball_1", "sk:in", "box_b")
        bench.run("drive", Location=None, Box="box_b")

    assert texts() == ["red_ball_1", "ball_1"]


def test_inferred_values_are_reported_with_their_reasons() -> None:
    with bench_of(way(AssertEffects(0.01))) as bench:
        bench.run("drive", Location="box_a")

        assert "Robot = robot_1: the only one that fits" in [event.text for event in bench.events]


def test_a_parameter_that_cannot_be_inferred_is_named_and_nothing_runs() -> None:
    outcome = run(way(note("body"), with_gripper(pre=(~REACHABLE("Location"), REACHABLE("Location")))), Location=None)

    assert isinstance(outcome, Failure)
    assert outcome.reason.startswith("drive: parameter Location not specified")
    assert lived == []


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"Location": "ball_1"}, "Location"),
        ({"Location": "nowhere"}, "nowhere"),
        ({"Location": 7}, "Location"),
        ({"Lokation": "box_a"}, "Did you mean 'Location'?"),
        ({"Base": "arm_1"}, "Base"),
    ],
)
def test_a_wrong_parameter_fails_the_run_by_name_before_anything_runs(arguments: dict[str, Any], told: str) -> None:
    outcome = run(way(note("body")), **arguments)

    assert isinstance(outcome, Failure)
    assert outcome.reason.startswith("drive: ")
    assert told in outcome.reason
    assert lived == []


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (Do.of("note", text=3, cycles="many"), "cycles"),
        (Do.of("note"), "note: text: not specified"),
        (Do.of("note", txt="a"), "unknown parameter 'txt'"),
        (Do.of("nod", text="a"), "unknown module 'nod'"),
    ],
)
def test_a_wrong_constant_in_a_body_fails_that_part_only(wrong: Do, told: str) -> None:
    with bench_of(way(Fallback.of(wrong, note("instead", goes="box_a")))) as bench:
        assert isinstance(bench.run("drive", Location="box_a"), Success)
    assert texts() == ["instead"]

    outcome = run(way(Sequence.of(wrong, note("next")), finish=note("finish")))
    assert isinstance(outcome, Failure)
    assert told in outcome.reason
    assert texts() == ["instead", "finish"]


EMPTY = EMPTY_HANDED("Gripper")
MAYBE = replace(AFTER, params=(*AFTER.params, replace(GRIPPER, kind=Kind.OPTIONAL)))


@pytest.mark.parametrize(
    "skill",
    [
        way(AssertEffects(0.01), replace(MAYBE, pre=(EMPTY,))),
        way(AssertEffects(0.01), replace(MAYBE, hold=(EMPTY,))),
        way(note("body", goes="box_a"), replace(MAYBE, post=(*MAYBE.post, EMPTY))),
        way(AssertEffects(0.01), MAYBE, when=(EMPTY,)),
        way(Guard.of(AssertEffects(0.01), EMPTY), MAYBE),
        way(Sequence.of(Check.of(EMPTY), AssertEffects(0.01)), MAYBE),
    ],
    ids=["pre", "hold", "post", "when", "guard", "check"],
)
def test_conditions_about_an_omitted_optional_parameter_are_not_checked(skill: Skill) -> None:
    with bench_of(skill) as bench:
        assert bench.managers["base_1"].panel("drive", {"Location": "box_a"}).ready
        assert isinstance(bench.run("drive", Location="box_a"), Success)


# ------------------------------------------------------------------ conditions that break


def _stripped(view: WorldView, robot: str, base: str) -> Verdict:
    raise ValueError("no such gear")


GEARED = ConditionType(
    "Geared", (ROBOT, Role("base", "sk:Base")), Computed("tiny:fitsIn", "robot", "base", _stripped), "-"
)("Robot", "Base")
TOLD = "ValueError: no such gear (in condition Geared(robot_1, base_1))"


@pytest.mark.parametrize(
    ("skill", "ran"),
    [
        (way(note("body"), replace(AFTER, pre=(GEARED,)), finish=note("finish")), []),
        (way(note("body"), when=(GEARED,), finish=note("finish")), []),
        (way(note("body"), replace(AFTER, hold=(GEARED,)), finish=note("finish")), ["finish"]),
        (way(Guard.of(note("body"), GEARED), finish=note("finish")), ["finish"]),
        (way(note("body"), replace(AFTER, post=(GEARED,)), finish=note("finish")), ["body", "finish"]),
    ],
    ids=["pre", "when", "hold", "guard", "post"],
)
def test_a_condition_that_raises_fails_its_skill_names_both_and_runs_the_required_later_phases(
    skill: Skill, ran: list[str]
) -> None:
    with bench_of(skill) as bench:
        other = bench.start("note", text="another", cycles=20)
        outcome = bench.run("drive", Location="box_a", Base="base_1", Robot="robot_1")

        assert isinstance(outcome, Failure)
        assert outcome.reason.startswith("drive")
        assert TOLD in outcome.reason
        bench.until(lambda: other.done)
        assert other.result == Success()
        assert [e.status for e in bench.events if e.module == "drive"][-1] is Status.ERROR
    assert [text for text in texts() if text != "another"] == ran


def test_a_condition_that_raises_is_shown_as_false_with_its_reason() -> None:
    with bench_of(way(note("body"), replace(AFTER, pre=(GEARED,)))) as bench:
        panel = bench.managers["base_1"].panel("drive", {"Location": "box_a", "Base": "base_1", "Robot": "robot_1"})

    (row,) = (row for row in panel.rows if row.kind == "pre")
    assert row.verdict is not None
    assert not row.verdict
    assert TOLD in "\n".join(row.verdict.lines())


def test_the_next_implementation_is_tried_if_a_condition_of_one_raises() -> None:
    bad, good = way(note("a"), label="a", when=(GEARED,)), way(note("b", goes="box_a"), label="b")

    assert isinstance(run(bad, good), Success)
    assert texts() == ["b"]
