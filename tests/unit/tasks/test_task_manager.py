from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import pytest

from skiros_py.behaviours import AssertEffects, Do, P, Sequence, Wait
from skiros_py.errors import PlanningError
from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.planning.plan import Plan
from skiros_py.skills.outcome import OBSTRUCTED, Failure, Outcome, Success
from skiros_py.skills.parameters import param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.tasks.policy import Policy
from skiros_py.tasks.trace import TraceEventKind
from skiros_py.testing import Bench, GivenPlanner, tiny_world
from skiros_py.testing.tiny import DRIVE, PICK, PLACE, pretend
from skiros_py.world.world import World

BALLS = 'scene:ball_2 a tiny:Ball ; rdfs:label "ball two" ; sk:in scene:box_a .'


class Try(Primitive[Any]):
    """Fails on one thing, so often as told."""

    name: ClassVar[str] = "try"
    clumsy: ClassVar[dict[str, int]] = {}
    code: ClassVar[int] = -1

    @dataclass(frozen=True, slots=True)
    class Params:
        ball: str = param("sk:SpatialThing", "What to try.")

    def execute(self) -> Execution[Outcome]:
        yield
        left = self.clumsy.get(self.params.ball, 0)
        if left:
            self.clumsy[self.params.ball] = left - 1
            return Failure(f"{self.params.ball} slipped", self.code, {"blocked_by": ["robot_2"]})
        return Success()


TRYING = (
    pretend(DRIVE),
    pretend(PICK, Sequence.of(Do.of("try", ball=P("Ball")), AssertEffects(0.02))),
    pretend(PLACE),
)


class Go(Primitive[Any]):
    """Notes what the next steps are about; fails where that is what it cannot reach."""

    name: ClassVar[str] = "go"
    ahead: ClassVar[list[frozenset[str]]] = []
    out_of_reach: ClassVar[set[str]] = set()

    @dataclass(frozen=True, slots=True)
    class Params:
        robot: str = param("sk:Robot", "Who goes.")

    def execute(self) -> Execution[Outcome]:
        yield
        self.ahead.append(self.context.ahead)
        missing = sorted(self.out_of_reach & self.context.ahead)
        return (
            Failure("it is too far away", values={"cause": "reach", "out_of_reach": missing}) if missing else Success()
        )


GOING = (pretend(DRIVE, Sequence.of(Do.of("go", robot=P("Robot")), AssertEffects(0.02))), pretend(PICK), pretend(PLACE))


@pytest.fixture(autouse=True)
def _forget() -> None:
    Try.clumsy.clear()
    Go.ahead.clear()
    Go.out_of_reach.clear()


def trying(world: World, **clumsy: int) -> Bench:
    Try.clumsy.update(clumsy)
    return Bench(world, TRYING, (Try,))


def picks(bench: Bench) -> list[str]:
    return [step.arguments["Ball"] for step in bench.tasks.steps if step.skill == "pick"]


def test_a_goal_is_planned_and_done() -> None:
    with Bench(tiny_world()) as bench:
        report = bench.pursue("In(ball_1, slot_1)", "In(RedBall, slot_2)")

        assert report.reached
        assert bench.world.related("ball_1", "sk:in", "slot_1")
        assert bench.world.related("red_ball_1", "sk:in", "slot_2")
    assert len(bench.plans) == 1
    assert [c.tries for c in report.conditions] == [1, 1]


def test_a_goal_that_holds_already_does_nothing() -> None:
    with Bench(tiny_world()) as bench:
        before = bench.world.version
        report = bench.pursue("In(ball_1, box_a)")

        assert bench.world.version == before
    assert report.reached
    assert (report.steps, report.simulated, bench.plans) == ((), 0.0, [])
    assert report.conditions[0].tries == 0


def test_a_step_that_fails_once_is_retried() -> None:
    with trying(tiny_world(), ball_1=1) as bench:
        report = bench.pursue("In(ball_1, slot_1)")

    assert report.reached
    assert picks(bench) == ["ball_1", "ball_1"]
    assert [step.reason for step in report.steps if step.skill == "pick"] == ["ball_1 slipped", ""]
    assert report.conditions[0].tries == 2


def test_a_target_that_keeps_failing_is_left_for_another_of_its_class() -> None:
    world = tiny_world(BALLS)
    with trying(world, ball_1=99) as bench:
        report = bench.pursue("In(Ball, slot_1)", "In(Ball, slot_2)")

    assert report.reached
    assert picks(bench).count("ball_1") <= 3
    assert world.related("ball_1", "sk:in", "box_a")


def test_after_so_many_failures_a_target_is_given_up_and_the_rest_is_still_done() -> None:
    world = tiny_world()
    with trying(world, red_ball_1=99) as bench:
        report = bench.pursue("In(RedBall, slot_1)", "In(ball_1, slot_2)")

    red, plain = report.conditions
    assert picks(bench).count("red_ball_1") == 3
    assert (red.believed, red.tries) == (False, 3)
    assert red.reason == "red_ball_1 slipped; gave up on red_ball_1 after 3 failed tries"
    assert (plain.believed, plain.reason) == (True, "")
    assert not report.reached
    assert report.no_plan == ()


def hard_to_reach(world: World, box: str) -> Bench:
    Try.clumsy[box] = 99
    drive = pretend(DRIVE, Sequence.of(Do.of("try", ball=P("Location")), AssertEffects(0.02)))
    return Bench(world, (drive, *TRYING[1:]), (Try,))


def test_a_place_that_cannot_be_reached_is_given_up_and_what_is_elsewhere_is_still_done() -> None:
    with hard_to_reach(tiny_world(), "box_b") as bench:
        report = bench.pursue("In(red_ball_1, slot_1)", "In(ball_1, slot_2)")

    far, near = report.conditions
    assert [step.arguments["Location"] for step in report.steps if step.skill == "drive"].count("box_b") == 3
    assert not far.believed
    assert "box_b was given up: box_b slipped" in far.reason
    assert (near.believed, near.reason) == (True, "")


def test_instead_of_what_is_at_a_place_that_cannot_be_reached_its_like_from_elsewhere_is_taken() -> None:
    with hard_to_reach(tiny_world("scene:a_red_ball a tiny:RedBall ; sk:in scene:box_a ."), "box_a") as bench:
        report = bench.pursue("In(RedBall, slot_1)")

    assert report.reached
    assert [step.arguments.get("Location") for step in report.steps if step.reason] == ["box_a"] * 3


def test_how_often_is_enough_can_be_chosen() -> None:
    Try.clumsy["red_ball_1"] = 99
    with Bench(tiny_world(), TRYING, (Try,), policy=Policy(attempts=1)) as bench:
        bench.pursue("In(RedBall, slot_1)")

    assert picks(bench) == ["red_ball_1"]


def test_robots_in_the_way_are_noted_and_are_no_failure_at_the_target(monkeypatch: pytest.MonkeyPatch) -> None:
    Try.clumsy["red_ball_1"] = 2
    monkeypatch.setattr(Try, "code", OBSTRUCTED)
    with Bench(tiny_world(), TRYING, (Try,), policy=Policy(attempts=1)) as bench:
        task = bench.tasks.begin(bench.goal("In(RedBall, slot_1)"))
        bench.runtime.finish(task)

    failed = [entry.data for entry in task.trace.entries if entry.what is TraceEventKind.FAILED]
    assert task.result.reached
    assert [(data["code"], data["blocked_by"]) for data in failed] == [(OBSTRUCTED, ["robot_2"])] * 2


def test_a_goal_without_a_plan_is_answered_with_reasons_and_nothing_is_done() -> None:
    with Bench(tiny_world("scene:giant_1 a tiny:Giant ; sk:in scene:box_a .")) as bench:
        report = bench.pursue("In(giant_1, slot_1)", "In(ball_1, slot_2)")

    assert not report.reached
    assert report.steps == ()
    assert "needs that giant_1 fits in slot_1" in report.no_plan[0]
    assert [c.reason for c in report.conditions] == ["; ".join(report.no_plan)] * 2


def test_a_skill_is_cancelled_when_the_world_makes_its_plan_pointless() -> None:
    world = tiny_world(BALLS)

    def take_it_away(event: ModuleEvent) -> None:
        if event.module == "drive" and event.status is Status.STARTED and world.placement("ball_1").place == "box_a":  # type: ignore[union-attr]
            with world.transaction("somebody", "moved it by hand") as tx:
                tx.place("ball_1", "sk:in", "box_b")

    with Bench(world) as bench:
        bench.monitor.subscribe(take_it_away)
        report = bench.pursue("In(ball_1, slot_1)")

    first = report.steps[0]
    assert first.reason.startswith("the plan no longer leads to the goal: ball_1 is not in box_a")
    assert report.reached
    assert [s.arguments["Location"] for s in report.steps if s.skill == "drive"] == ["box_a", "box_b"]


def test_being_cancelled_is_no_failure_of_the_target() -> None:
    world = tiny_world()
    with Bench(world, policy=Policy(attempts=1)) as bench:
        moves = iter(["box_b", "box_a", "box_b"])

        def tease(event: ModuleEvent) -> None:
            if event.module == "drive" and event.status is Status.STARTED and (place := next(moves, None)):
                with world.transaction("somebody", "moved it by hand") as tx:
                    tx.place("ball_1", "sk:in", place)

        bench.monitor.subscribe(tease)
        report = bench.pursue("In(ball_1, slot_1)")

    assert sum(step.reason != "" for step in report.steps) >= 1
    assert report.conditions[0].reason == "" or "slipped" not in report.conditions[0].reason


def test_an_irrelevant_change_cancels_nothing() -> None:
    world = tiny_world()

    def meddle(event: ModuleEvent) -> None:
        if event.module == "drive" and event.status is Status.STARTED:
            with world.transaction("somebody", "tidied up") as tx:
                tx.place("red_ball_1", "sk:in", "box_a")

    with Bench(world) as bench:
        bench.monitor.subscribe(meddle)
        report = bench.pursue("In(ball_1, slot_1)")

    assert report.reached
    assert [step.skill for step in report.steps] == ["drive", "pick", "place"]


def test_steps_whose_effects_already_hold_are_skipped() -> None:
    world = tiny_world()

    def help_out(event: ModuleEvent) -> None:
        if event.module == "drive" and event.status is Status.TERMINATED:
            with world.transaction("somebody", "was quicker") as tx:
                tx.place("ball_1", "sk:in", "slot_1")

    with Bench(world) as bench:
        bench.monitor.subscribe(help_out)
        report = bench.pursue("In(ball_1, slot_1)")

    assert report.reached
    assert [step.skill for step in report.steps] == ["drive"]


def test_a_wrong_plan_is_never_begun() -> None:
    with Bench(tiny_world(), planner=GivenPlanner("pick arm_1 gripper_1 robot_1 box_a ball_1")) as bench:
        with pytest.raises(PlanningError, match=r"the plan of given breaks at step 1 \(pick\("):
            bench.pursue("In(ball_1, slot_1)")

        assert bench.events == []


def test_capabilities_are_what_the_world_says_is_there() -> None:
    world = tiny_world(robots=2)
    with Bench(world, robots=["robot_1"]) as bench:
        assert {c.skill.name: c.agents for c in bench.tasks.capabilities} == {
            "drive": ("base_1",),
            "pick": ("arm_1",),
            "place": ("arm_1",),
        }

        with world.transaction("test", "the arm forgets how to pick") as tx:
            pick = next(s for s in world.objects("arm_1", "sk:hasSkill") if world.element(s).label == "pick")
            tx.unrelate("arm_1", "sk:hasSkill", pick)

        assert [c.skill.name for c in bench.tasks.capabilities] == ["drive", "place"]


def test_two_robots_share_a_goal_each_by_its_own_hands() -> None:
    world = tiny_world(robots=2)
    with world.transaction("test", "each at a box") as tx:
        tx.place("robot_1", "sk:at", "box_a")
        tx.place("robot_2", "sk:at", "box_b")

    with Bench(world) as bench:
        report = bench.pursue("Holding(gripper_1, ball_1)", "Holding(gripper_2, red_ball_1)")

    assert report.reached
    assert sorted((s.skill, s.arguments["Arm"]) for s in report.steps) == [("pick", "arm_1"), ("pick", "arm_2")]


def test_equal_runs_are_equal() -> None:
    def run() -> list[tuple[object, ...]]:
        with trying(tiny_world(), ball_1=1) as bench:
            report = bench.pursue("In(ball_1, slot_1)", "In(RedBall, slot_2)")
        return [(s.skill, s.arguments, s.start, s.end, s.reason) for s in report.steps]

    assert run() == run()


def test_a_target_given_up_does_not_come_back_by_being_named_in_the_goal() -> None:
    with trying(tiny_world(), ball_1=99) as bench:
        report = bench.pursue("In(ball_1, slot_1)", "In(red_ball_1, slot_2)")

    named, other = report.conditions
    assert picks(bench).count("ball_1") == 3
    assert (named.believed, named.tries) == (False, 3)
    assert named.reason == "ball_1 slipped; gave up on ball_1 after 3 failed tries"
    assert (other.believed, other.reason) == (True, "")
    assert report.no_plan == ()


def test_a_condition_that_names_a_target_given_up_but_holds_is_kept() -> None:
    Try.clumsy["box_a"] = 99
    skills = (pretend(DRIVE, Sequence.of(Do.of("try", ball=P("Location")), AssertEffects(0.02))), *TRYING[1:])
    with Bench(tiny_world(), skills, (Try,)) as bench:
        report = bench.pursue("Reachable(box_a)", "At(robot_1, box_a)")

    assert [(c.believed, c.tries) for c in report.conditions] == [(True, 0), (False, 3)]
    assert report.conditions[0].reason == ""


def test_the_next_goal_starts_with_a_clean_slate() -> None:
    with trying(tiny_world(), ball_1=3) as bench:
        first = bench.pursue("In(ball_1, slot_1)")
        second = bench.pursue("In(ball_1, slot_1)")

    assert (first.reached, second.reached) == (False, True)
    assert [s.skill for s in second.steps] == ["pick", "place"]
    assert (second.conditions[0].tries, second.conditions[0].reason) == (1, "")


def test_steps_of_an_earlier_goal_are_not_reported_again() -> None:
    with Bench(tiny_world()) as bench:
        bench.pursue("In(ball_1, slot_1)")
        second = bench.pursue("In(red_ball_1, slot_2)")
        third = bench.pursue("In(red_ball_1, slot_1)")

    assert [s.skill for s in second.steps] == ["drive", "pick", "place"]
    assert third.steps == ()
    assert "ball_1 is in slot_1" in third.no_plan[0]


def test_times_of_conditions_are_those_of_the_steps_that_brought_them_about() -> None:
    with Bench(tiny_world()) as bench:
        report = bench.pursue("In(ball_1, slot_1)", "In(RedBall, slot_2)")

    ends = {s.arguments["Slot"]: s.end for s in report.steps if s.skill == "place"}
    times = [c.simulated for c in report.conditions]
    assert times == pytest.approx([ends["slot_1"], ends["slot_2"]], abs=0.011)
    assert max(ends.values()) == pytest.approx(report.simulated, abs=0.011)
    assert all(c.wall is not None and 0.0 < c.wall <= report.wall for c in report.conditions)


def test_times_count_from_the_start_of_their_own_goal() -> None:
    with Bench(tiny_world()) as bench:
        first = bench.pursue("In(ball_1, slot_1)")
        second = bench.pursue("In(ball_1, slot_1)", "In(red_ball_1, slot_2)")

    held, brought = second.conditions
    assert (held.simulated, held.tries) == (0.0, 0)
    assert brought.simulated == pytest.approx(second.simulated, abs=0.011)
    assert second.simulated == pytest.approx(first.simulated, abs=0.02), "not counted on from the first"


def test_a_condition_that_is_not_believed_at_the_end_has_no_time() -> None:
    with trying(tiny_world(), ball_1=99) as bench:
        report = bench.pursue("Free(slot_2)", "Holding(gripper_1, ball_1)")

    assert [c.believed for c in report.conditions] == [True, False]
    assert [c.simulated is None for c in report.conditions] == [False, True]
    assert report.conditions[1].wall is None


def test_a_condition_lost_again_has_the_time_when_it_came_to_hold_for_good() -> None:
    world = tiny_world()

    def take_it_out(event: ModuleEvent) -> None:
        if event.module == "place" and event.status is Status.TERMINATED and world.related("ball_1", "sk:in", "slot_1"):
            with world.transaction("somebody", "took it out, once") as tx:
                tx.place("ball_1", "sk:in", "box_b")
            taken.append(event.time)

    taken: list[float] = []
    with Bench(world) as bench:
        bench.monitor.subscribe(lambda event: None if taken else take_it_out(event))
        report = bench.pursue("In(ball_1, slot_1)")

    assert report.reached
    assert len(taken) == 1
    assert report.conditions[0].simulated == pytest.approx(report.simulated, abs=0.011)
    assert report.conditions[0].simulated > taken[0]


def test_a_step_whose_skill_runs_already_waits_and_says_so_once_and_the_plan_is_still_looked_after() -> None:
    with Bench(tiny_world(), (pretend(DRIVE, Sequence.of(Wait(3.0), AssertEffects(0.0))), pretend(PICK))) as bench:
        busy = bench.start("drive", Location="box_b")
        task = bench.tasks.begin(bench.goal("Holding(gripper_1, ball_1)"))
        bench.until(lambda: [e for e in bench.events if "is running already" in e.text])
        bench.advance(0.1)
        assert [e.text for e in bench.events if "waits" in e.text] == ["waits: drive of base_1 is running already"]
        with bench.world.transaction("somebody", "carried the ball away") as tx:
            tx.place("ball_1", "sk:in", "box_b")
        bench.until(lambda: len(bench.plans) == 2, limit=0.5)  # while the other one still runs

        assert not busy.done
        assert bench.cycle.run(task).reached


def test_a_step_knows_what_the_next_steps_are_about_up_to_the_next_one_like_it() -> None:
    with Bench(tiny_world(), GOING, (Go,)) as bench:
        assert bench.pursue("In(ball_1, slot_1)", "In(red_ball_1, slot_2)").reached

        (plan,) = bench.plans
    assert isinstance(plan.outcome, Plan)
    steps = plan.outcome.steps
    drives = [number for number, step in enumerate(steps) if step.skill == "drive"]
    for ahead, first, end in zip(Go.ahead, drives, [*drives[1:], len(steps)], strict=True):
        assert ahead == {value for step in steps[first + 1 : end] for value in step.arguments.values()}


def test_what_a_step_says_is_out_of_reach_is_left_out_at_once_and_the_rest_is_done() -> None:
    Go.out_of_reach.add("ball_1")
    with Bench(tiny_world(), GOING, (Go,)) as bench:
        report = bench.pursue("In(ball_1, slot_1)", "In(red_ball_1, slot_2)")

    assert [step.reason for step in report.steps].count("it is too far away") == 1
    assert [c.believed for c in report.conditions] == [False, True]
    assert report.conditions[0].reason == "it is too far away"
