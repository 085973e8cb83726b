"""What a task does when the world, or who can do what, changes behind its plan."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import pytest

from skiros_py.behaviours import AssertEffects, Do, P, Sequence, Wait
from skiros_py.errors import DeviceError
from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.skills.surroundings import robot_of
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.policy import Policy
from skiros_py.tasks.report import GoalReport
from skiros_py.tasks.report import Outcome as TaskOutcome
from skiros_py.tasks.trace import TraceEventKind
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import DRIVE, PICK, PLACE, pretend

GOAL = "In(ball_1, slot_1)"
BALLS = "".join(f'scene:ball_{n} a tiny:Ball ; rdfs:label "ball {n}" ; sk:in scene:box_b .\n' for n in (2, 3))
SLOW = tuple(pretend(skill, Sequence.of(Wait(1.0), AssertEffects(0.0))) for skill in (DRIVE, PICK, PLACE))


class Grasp(Primitive[Any]):
    """Slips so often as told."""

    name: ClassVar[str] = "grasp"
    slips: ClassVar[dict[str, int]] = {}

    @dataclass(frozen=True, slots=True)
    class Params:
        ball: str = param("tiny:Ball", "What to grasp.")

    def execute(self) -> Execution[Outcome]:
        yield
        left = self.slips.get(self.params.ball, 0)
        self.slips[self.params.ball] = max(0, left - 1)
        return Failure(f"{self.params.ball} slipped") if left else Success()


GRASPING = (
    pretend(DRIVE),
    pretend(PICK, Sequence.of(Do.of("grasp", ball=P("Ball")), AssertEffects(0.02))),
    pretend(PLACE),
)
LIAR = (pretend(DRIVE), pretend(PICK, Wait(0.1)), pretend(PLACE))
"""The pick says that it worked, and nothing of what it promises is so."""


@pytest.fixture(autouse=True)
def _forget() -> None:
    Grasp.slips.clear()


def begin(bench: Bench, *goal: str, policy: Policy | None = None) -> TaskHandle:
    return bench.tasks.begin(bench.goal(*(goal or (GOAL,))), policy=policy)


def finish(bench: Bench, task: TaskHandle, limit: float = 60.0) -> GoalReport:
    bench.until(lambda: task.done, limit=limit)
    assert task.report is not None
    return task.report


def told(task: TaskHandle, what: TraceEventKind) -> list[str]:
    return [entry.text for entry in task.trace.entries if entry.what is what]


# ------------------------------------------------------------------ what fails


def test_a_step_that_failed_is_repeated_without_planning_where_the_plan_is_still_right() -> None:
    Grasp.slips["ball_1"] = 2
    with Bench(tiny_world(), GRASPING, (Grasp,)) as bench:
        task = begin(bench)
        report = finish(bench, task)

    assert report.reached
    assert len(bench.plans) == 1
    assert told(task, TraceEventKind.RETRIED) == ["pick failed: ball_1 slipped: it is tried again"] * 2
    failed = next(s for s in report.steps if s.reason)
    again = next(s for s in report.steps if s.start > failed.start)
    assert again.start == pytest.approx(failed.end)


def test_a_skill_whose_declared_effect_does_not_happen_is_retried_and_given_up_with_the_reason() -> None:
    with Bench(tiny_world(), LIAR) as bench:
        task = begin(bench)
        report = finish(bench, task)

        assert bench.world.related("ball_1", "sk:in", "box_a"), "what a plan supposes is never believed"
    assert report.outcome is TaskOutcome.NOT_REACHED
    assert [s.skill for s in report.steps] == ["drive", "pick", "pick", "pick"]
    assert "postcondition Holding(gripper_1, ball_1)" in report.conditions[0].reason
    assert "gave up on ball_1 after 3 failed tries" in report.conditions[0].reason


def test_the_remaining_goal_is_reached_if_the_policy_says_so() -> None:
    Grasp.slips["ball_1"] = 99
    with Bench(tiny_world(), GRASPING, (Grasp,)) as bench:
        task = begin(bench, GOAL, "In(red_ball_1, slot_2)", policy=Policy(rest=True))
        report = finish(bench, task)

    given_up, done = report.conditions
    assert report.outcome is TaskOutcome.PARTLY_REACHED
    assert "slipped" in given_up.reason
    assert done.believed
    assert len(told(task, TraceEventKind.GIVEN_UP)) == 1


def test_the_remaining_goal_is_left_if_the_policy_says_so() -> None:
    Grasp.slips["ball_1"] = 99
    with Bench(tiny_world(), GRASPING, (Grasp,)) as bench:
        task = begin(bench, GOAL, "In(red_ball_1, slot_2)", policy=Policy(rest=False, attempts=1))
        report = finish(bench, task)

    picks = [s.arguments["Ball"] for s in report.steps if s.skill == "pick"]
    assert picks[-1] == "ball_1"
    assert not report.reached
    assert all(c.reason for c in report.conditions if not c.believed)


# ------------------------------------------------------------------ a world that changes


def when(bench: Bench, skill: str, status: Status, action: Callable[[], None]) -> None:
    """Does something once, at the first event of a kind."""
    happened: list[ModuleEvent] = []

    def listen(event: ModuleEvent) -> None:
        if event.module == skill and event.status is status and not happened:
            happened.append(event)
            action()

    bench.monitor.subscribe(listen)


def move(bench: Bench, ball: str, relation: str, place: str) -> None:
    with bench.world.transaction("somebody", "moved it by hand") as tx:
        tx.place(ball, relation, place)


def test_a_moved_part_is_replanned_and_the_trace_gives_the_reason() -> None:
    with Bench(tiny_world(), SLOW) as bench:
        when(bench, "drive", Status.STARTED, lambda: move(bench, "ball_1", "sk:in", "box_b"))
        task = begin(bench)
        report = finish(bench, task)

    assert report.reached
    assert told(task, TraceEventKind.REPLANS) == ["replans: ball_1 is not in box_a: it is in box_b"]
    assert len(bench.plans) == 2


def test_a_part_that_is_removed_leaves_a_goal_that_names_it_out_of_reach() -> None:
    def remove() -> None:
        with bench.world.transaction("somebody", "threw it away") as tx:
            tx.remove("ball_1")

    with Bench(tiny_world(), SLOW) as bench:
        when(bench, "drive", Status.STARTED, remove)
        task = begin(bench, GOAL, "In(red_ball_1, slot_2)")
        report = finish(bench, task)

    assert report.outcome is TaskOutcome.PARTLY_REACHED
    assert "ball_1" in report.conditions[0].reason


def test_a_finished_part_that_is_taken_out_again_is_put_back() -> None:
    with Bench(tiny_world(), SLOW) as bench:
        task = begin(bench, GOAL, "In(red_ball_1, slot_2)")
        bench.until(lambda: bench.world.related("ball_1", "sk:in", "slot_1") or task.done)
        bench.advance(0.5)
        move(bench, "ball_1", "sk:in", "box_a")
        report = finish(bench, task)

    assert report.reached


def test_a_world_that_flips_for_ever_ends_the_task_after_a_bounded_number_of_plans() -> None:
    with Bench(tiny_world()) as bench:

        def tease(event: ModuleEvent) -> None:
            if event.module == "drive" and event.status is Status.STARTED:
                here = bench.world.objects("ball_1", "sk:in")[0]
                move(bench, "ball_1", "sk:in", "box_b" if here == "box_a" else "box_a")

        bench.monitor.subscribe(tease)
        task = begin(bench)
        report = finish(bench, task)

    assert not report.reached
    assert len(bench.plans) <= 9
    assert report.conditions[0].reason.startswith("gave up after 9 plans and retries: ")
    assert "ball_1" in report.conditions[0].reason  # what went wrong last


def test_changes_that_nothing_of_the_plan_reads_are_not_even_looked_at() -> None:
    with Bench(tiny_world(BALLS), SLOW) as bench:
        task = begin(bench)
        bench.until(lambda: "drive" in bench.managers["base_1"].running)
        for _ in range(20):
            move(bench, "ball_2", "sk:in", "box_a")
            bench.cycle.step()
            move(bench, "ball_2", "sk:in", "box_b")
            bench.cycle.step()
        report = finish(bench, task)

    assert report.reached
    assert [s.skill for s in report.steps] == ["drive", "pick", "place"]
    assert told(task, TraceEventKind.REPLANS) == []


def test_a_change_that_fulfils_the_goal_ends_the_task_and_its_running_steps() -> None:
    with Bench(tiny_world(), SLOW) as bench:
        when(bench, "drive", Status.STARTED, lambda: move(bench, "ball_1", "sk:in", "slot_1"))
        task = begin(bench)
        report = finish(bench, task, limit=0.5)

    assert report.outcome is TaskOutcome.REACHED
    assert report.steps[0].reason == "nothing more is to be done"


# ------------------------------------------------------------------ managers that come and go


def test_a_manager_lost_in_mid_step_has_its_step_stopped_and_another_robot_does_it() -> None:
    with Bench(tiny_world(robots=2), SLOW) as bench:
        task = begin(bench)
        bench.until(lambda: any("pick" in m.running for m in bench.managers.values()))
        lost = next(a for a, m in bench.managers.items() if "pick" in m.running)
        bench.advance(0.3)
        bench.managers[lost].lose("its host is gone")
        bench.advance(0.1)
        assert "pick" not in bench.managers[lost].running
        report = finish(bench, task)

    assert report.reached
    assert report.steps[-1].agent not in (lost, "")
    assert next(s for s in report.steps if s.reason).agent == lost


def test_a_manager_lost_that_the_rest_of_the_plan_counts_on_is_replanned_at_once() -> None:
    with Bench(tiny_world(robots=2), SLOW) as bench:
        task = begin(bench)
        bench.until(lambda: any("drive" in m.running for m in bench.managers.values()))
        base = next(a for a, m in bench.managers.items() if "drive" in m.running)
        arm = base.replace("base", "arm")
        bench.managers[arm].lose("its host is gone")
        report = finish(bench, task)

    assert report.reached
    assert told(task, TraceEventKind.REPLANS) == [f"replans: {arm} has no skill pick any more"]
    assert report.steps[-1].agent != arm


def test_a_manager_that_appears_helps_where_nobody_could() -> None:
    with Bench(tiny_world(), SLOW) as bench:
        bench.managers.close("arm_1")
        task = begin(bench, policy=Policy(ask=True))
        bench.until(lambda: task.status == "waiting")
        bench.managers.open("arm_1")
        report = finish(bench, task)

        assert bench.questions.open == ()
    assert report.reached


# ------------------------------------------------------------------ what was tried before


class Put(Primitive[Any]):
    """Never works, each time in another way."""

    name: ClassVar[str] = "put"

    @dataclass(frozen=True, slots=True)
    class Params:
        slot: str = param("tiny:Slot", "Where to put it.")

    def execute(self) -> Execution[Outcome]:
        yield
        way = self.context.tried.fresh("way", range(4))[0]
        self.context.tried.note("way", way, f"way {way}")
        return Failure(f"no room in {self.params.slot}")


PUTTING = (pretend(DRIVE), pretend(PICK), pretend(PLACE, Do.of("put", slot=P("Slot"))))
SLOTS = "".join(f'scene:slot_{n} a tiny:Slot ; rdfs:label "slot {n}" ; sk:on scene:floor .\n' for n in (3, 4, 5))


def test_what_fits_nowhere_is_tried_three_times_in_all_each_time_in_another_way() -> None:
    slots = [f"slot_{n}" for n in (1, 2, 3, 4, 5)]
    with Bench(tiny_world(SLOTS), PUTTING, (Put,)) as bench:
        task = begin(bench, " or ".join(f"In(ball_1, {slot})" for slot in slots), policy=Policy(attempts=3))
        report = finish(bench, task)

    assert [step.skill for step in report.steps].count("place") == 3
    assert "(tried: way 0, way 1, way 2)" in report.conditions[0].reason
    failed = [entry.data["tried"] for entry in task.trace.entries if entry.what is TraceEventKind.FAILED]
    assert failed == [{"way": [0]}, {"way": [0, 1]}, {"way": [0, 1, 2]}]


def test_a_cause_that_is_not_the_target_is_not_tried_three_times_at_each() -> None:
    class Stuck(Put):
        name: ClassVar[str] = "stuck"

        def execute(self) -> Execution[Outcome]:
            yield
            return Failure("the arm cannot go home")

    skills = (pretend(DRIVE), pretend(PICK), pretend(PLACE, Do.of("stuck", slot=P("Slot"))))
    goal = [f"In({ball}, {slot})" for ball, slot in (("ball_1", "slot_1"), ("red_ball_1", "slot_2"))]
    with Bench(tiny_world(), skills, (Stuck,)) as bench:
        report = finish(bench, begin(bench, *goal, policy=Policy(attempts=3)))

    assert [step.skill for step in report.steps].count("place") <= 4
    assert all("the arm cannot go home" in c.reason for c in report.conditions if c.tries)


# ------------------------------------------------------------------ what another try cannot change


class Reach(Primitive[Any]):
    """Reaches from some places only, with a device that answers or not."""

    name: ClassVar[str] = "reach"
    from_: ClassVar[frozenset[str]] = frozenset()
    dead: ClassVar[frozenset[str]] = frozenset()

    @dataclass(frozen=True, slots=True)
    class Params:
        arm: str = param("sk:Arm", "Which arm.")
        thing: str = param("sk:SpatialThing", "What to reach.")

    def execute(self) -> Execution[Outcome]:
        yield
        if self.params.arm in self.dead:
            raise DeviceError(f"the camera of {self.params.arm} does not answer")
        placement = self.world.placement(robot_of(self.world, self.params.arm))
        if placement is not None and placement.place in self.from_:
            return Success()
        return Failure(f"{self.params.thing} is too far away", values={"cause": "reach"})


@pytest.fixture
def reach(monkeypatch: pytest.MonkeyPatch) -> type[Reach]:
    monkeypatch.setattr(Reach, "from_", frozenset({"box_a", "box_b"}))
    monkeypatch.setattr(Reach, "dead", frozenset[str]())
    return Reach


def reaching(thing: SkillDescription) -> Skill:
    return pretend(thing, Sequence.of(Do.of("reach", arm=P("Arm"), thing=P(thing.target)), AssertEffects(0.02)))


REACHING = (pretend(DRIVE), reaching(PICK), reaching(PLACE))


def failed(report: GoalReport) -> list[tuple[str, str]]:
    return [(step.skill, step.arguments["Arm"]) for step in report.steps if step.reason]


def test_what_is_out_of_reach_is_given_up_at_once_with_the_reason_and_the_rest_is_done(reach: type[Reach]) -> None:
    reach.from_ = frozenset({"box_b"})
    with Bench(tiny_world(), REACHING, (Reach,)) as bench:
        report = finish(bench, begin(bench, GOAL, "In(red_ball_1, slot_2)"))

    far, done = report.conditions
    assert [step.arguments["Ball"] for step in report.steps if step.reason] == ["ball_1"]
    assert "ball_1 is too far away" in far.reason
    assert done.believed


def test_what_is_out_of_reach_from_one_place_is_tried_from_another_next(reach: type[Reach]) -> None:
    class ReachSlot(Reach):
        name: ClassVar[str] = "reach_slot"
        from_: ClassVar[frozenset[str]] = frozenset({"box_b"})

    place = Sequence.of(Do.of("reach_slot", arm=P("Arm"), thing=P("Slot")), AssertEffects(0.02))
    skills = (pretend(DRIVE), reaching(PICK), pretend(PLACE, place))
    with Bench(tiny_world(), skills, (Reach, ReachSlot)) as bench:
        report = finish(bench, begin(bench, "In(ball_1, slot_1)"))

    assert report.reached
    assert [(step.skill, bool(step.reason)) for step in report.steps] == [
        *(("drive", False), ("pick", False), ("place", True)),
        *(("drive", False), ("place", False)),
    ]


def test_where_a_device_is_dead_its_robot_is_not_asked_again_and_another_does_it(reach: type[Reach]) -> None:
    reach.dead = frozenset({"arm_1"})
    with Bench(tiny_world(robots=2), REACHING, (Reach,)) as bench:
        report = finish(bench, begin(bench, GOAL, "In(red_ball_1, slot_2)"))

    assert report.reached
    assert failed(report) == [("pick", "arm_1")]
    assert {step.arguments["Arm"] for step in report.steps if step.skill == "place"} == {"arm_2"}


def test_a_device_that_nothing_replaces_is_the_reason_that_is_given_for_all(reach: type[Reach]) -> None:
    reach.dead = frozenset({"arm_1"})
    with Bench(tiny_world(), REACHING, (Reach,)) as bench:
        report = finish(bench, begin(bench, GOAL, "In(red_ball_1, slot_2)"))

    assert failed(report) == [("pick", "arm_1")]
    assert all("the camera of arm_1 does not answer" in condition.reason for condition in report.conditions)


def test_what_a_person_has_mended_is_tried_again(reach: type[Reach]) -> None:
    reach.dead = frozenset({"arm_1"})
    with Bench(tiny_world(), REACHING, (Reach,)) as bench:
        task = begin(bench, policy=Policy(ask=True))
        bench.until(lambda: task.status == "waiting")
        reach.dead = frozenset()
        (question,) = bench.questions.open
        bench.questions.answer(question.id, "retry", by="ada")
        report = finish(bench, task)

    assert report.reached
    assert failed(report) == [("pick", "arm_1")]
