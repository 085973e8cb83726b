"""Things that are only counted become elements just before the first step that uses them, and count once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import pytest

from skiros_py.behaviours import AssertEffects, Do, P, Sequence, Wait
from skiros_py.planning.plan import Plan
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.tasks.trace import StepRun
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import DRIVE, PICK, PLACE, pretend
from skiros_py.world.world import World

GIANTS = 'scene:box_a sk:hasA scene:giants . scene:giants a sk:Stock ; sk:stockOf "tiny:Giant" ; sk:stockCount 3 .'
GOAL = "exists g: Giant (Holding(gripper_1, g))"
HAND = {"Arm": "arm_1", "Gripper": "gripper_1", "Robot": "robot_1"}


class Grasp(Primitive[Any]):
    """Slips so often as told, whatever it is told to take."""

    name: ClassVar[str] = "grasp"
    slips: ClassVar[list[str]] = []
    left: ClassVar[int] = 0

    @dataclass(frozen=True, slots=True)
    class Params:
        ball: str = param("tiny:Ball", "What to grasp.")

    def execute(self) -> Execution[Outcome]:
        yield
        if type(self).left == 0:
            return Success()
        type(self).left -= 1
        self.slips.append(self.params.ball)
        return Failure(f"{self.params.ball} slipped")


GRASPING = (
    pretend(DRIVE),
    pretend(PICK, Sequence.of(Do.of("grasp", ball=P("Ball")), AssertEffects(0.02))),
    pretend(PLACE),
)
SLOW = tuple(pretend(skill, Sequence.of(Wait(1.0), AssertEffects(0.0))) for skill in (DRIVE, PICK, PLACE))


@pytest.fixture(autouse=True)
def _forget() -> None:
    Grasp.slips.clear()
    Grasp.left = 0


def left(world: World) -> object:
    return world.value("giants", "sk:stockCount")


def test_what_is_picked_is_an_element_from_then_on_and_one_less_is_in_stock() -> None:
    with Bench(tiny_world(GIANTS)) as bench:
        report = bench.pursue(GOAL)

        assert report.reached
        assert [step.arguments["Ball"] for step in report.steps if step.skill == "pick"] == ["giant_1"]
        assert bench.world.related("giant_1", "sk:heldBy", "gripper_1")
        assert left(bench.world) == 2


def test_nothing_becomes_an_element_before_the_step_that_uses_it() -> None:
    with Bench(tiny_world(GIANTS), SLOW) as bench:
        begun = bench.tasks.begin(bench.goal(GOAL))
        bench.until(lambda: begun.trace.entries and bench.world.placement("robot_1").place == "box_a")
        told: list[tuple[StepRun, bool]] = []
        begun.before_step(lambda run: told.append((run, bench.world.has("giant_1"))))

        assert not bench.world.has("giant_1")
        bench.until(lambda: begun.done)

    assert [(run.step.arguments["Ball"], there) for run, there in told] == [("giant_1", True)]
    assert begun.plan is not None
    assert begun.plan.steps[-1].arguments["Ball"] == "giant_1"


def test_an_element_is_taken_from_stock_in_one_change_with_task_and_step_as_author_and_reason() -> None:
    with Bench(tiny_world(GIANTS)) as bench:
        bench.tasks.begin(bench.goal(GOAL), name="kit 7")
        bench.until(lambda: bench.world.has("giant_1"))

        (change,) = (c for c in bench.world.changes if any("giants" in edit.concerns() for edit in c.edits[:5]))
    assert (change.author, change.reason) == ("kit 7", "arm_1: pick box_a giants#1 is next")


def test_after_a_failed_pick_the_same_thing_is_tried_again_and_counted_once() -> None:
    Grasp.left = 1
    with Bench(tiny_world(GIANTS), GRASPING, [Grasp]) as bench:
        report = bench.pursue(GOAL)

        assert report.reached
        assert Grasp.slips == ["giant_1"]
        assert bench.world.instances("tiny:Giant") == ("giant_1",)
        assert left(bench.world) == 2


def test_what_cannot_be_picked_stays_a_known_thing_and_another_one_is_taken() -> None:
    Grasp.left = 3
    with Bench(tiny_world(GIANTS), GRASPING, [Grasp]) as bench:
        report = bench.pursue(GOAL)

        assert report.reached
        assert Grasp.slips == ["giant_1"] * 3
        assert bench.world.related("giant_1", "sk:in", "box_a")
        assert bench.world.related("giant_2", "sk:heldBy", "gripper_1")
        assert left(bench.world) == 1


def test_where_every_pick_fails_the_whole_stock_is_tried_and_then_it_ends() -> None:
    Grasp.left = 100
    with Bench(tiny_world(GIANTS), GRASPING, [Grasp]) as bench:
        report = bench.pursue(GOAL)

        assert not report.reached
        assert len(bench.world.instances("tiny:Giant")) + int(str(left(bench.world))) == 3


def test_when_somebody_empties_the_stock_meanwhile_another_plan_is_made() -> None:
    with Bench(tiny_world(GIANTS, "scene:giant_9 a tiny:Giant ; sk:in scene:box_b ."), SLOW) as bench:
        with bench.world.transaction("ann", "out of the way") as tx:
            tx.place("giant_9", "sk:on", "floor")
        begun = bench.tasks.begin(bench.goal(GOAL))
        bench.until(lambda: begun.plan is not None)
        with bench.world.transaction("ann", "took them all, and brought one back") as tx:
            tx.set("giants", "sk:stockCount", 0)
            tx.place("giant_9", "sk:in", "box_b")
        bench.until(lambda: begun.done)

        assert begun.report is not None
        assert begun.report.reached
        assert bench.world.related("giant_9", "sk:heldBy", "gripper_1")
        assert "nothing is left in stock for giants#1" in str([entry.text for entry in begun.trace.entries])


def test_two_tasks_take_different_things_of_one_stock() -> None:
    with Bench(tiny_world(GIANTS, robots=2), SLOW) as bench:
        one, other = (bench.tasks.begin(bench.goal(f"exists g: Giant (Holding(gripper_{n}, g))")) for n in (1, 2))
        bench.until(lambda: one.done and other.done)

        held = {bench.world.subjects("sk:heldBy", f"gripper_{n}") for n in (1, 2)}
        assert held == {("giant_1",), ("giant_2",)}
        assert left(bench.world) == 1


def test_of_the_last_thing_in_stock_one_of_two_tasks_gets_nothing_and_says_so() -> None:
    with Bench(tiny_world(GIANTS.replace("Count 3", "Count 1"), robots=2), SLOW) as bench:
        tasks = [bench.tasks.begin(bench.goal(f"exists g: Giant (Holding(gripper_{n}, g))")) for n in (1, 2)]
        bench.until(lambda: all(task.done for task in tasks))

        assert sorted(bool(task.report and task.report.reached) for task in tasks) == [False, True]
        assert bench.world.instances("tiny:Giant") == ("giant_1",)


def test_a_sequence_made_of_a_plan_takes_from_stock_and_can_be_run_again() -> None:
    with Bench(tiny_world(GIANTS)) as bench:
        plan = bench.plan(GOAL).outcome
        assert isinstance(plan, Plan)
        assert not any(check.problems for check in bench.tasks.check(plan.steps))
        begun = bench.tasks.execute(plan.steps)
        bench.until(lambda: begun.done)

        assert bench.world.related("giant_1", "sk:heldBy", "gripper_1")
        assert left(bench.world) == 2
        assert tuple(step.arguments.get("Ball") for step in plan.steps) == (None, "giants#1")


def test_a_goal_that_holds_by_stock_is_done_at_once_and_leaves_the_stock_alone() -> None:
    with Bench(tiny_world(GIANTS)) as bench:
        report = bench.pursue("In(Giant, box_a)")

        assert report.reached
        assert report.steps == ()
        assert left(bench.world) == 3
