from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any, cast

from skiros_py.planning.plan import Step
from skiros_py.planning.planners.planner import Planners
from skiros_py.planning.replay import Flaw
from skiros_py.planning.requests import Check, supposing
from skiros_py.skills.conditions.watch import Reads, Watches
from skiros_py.tasks.context import Control
from skiros_py.tasks.dispatcher import Progress
from skiros_py.tasks.plan_monitor import PlanMonitor
from skiros_py.testing import GivenPlanner, tiny_world
from skiros_py.testing.tiny import DRIVE, IN_CONTAINER, PICK, PLACE
from skiros_py.world.world import World

SKILLS = {skill.name: skill for skill in (DRIVE, PICK, PLACE)}
HAND = {"Arm": "arm_1", "Gripper": "gripper_1", "Robot": "robot_1"}
DRIVING = Step("drive", {"Base": "base_1", "Robot": "robot_1", "Location": "box_a"})
REST = (
    Step("pick", {**HAND, "Box": "box_a", "Ball": "ball_1"}),
    Step("place", {**HAND, "Ball": "ball_1", "Slot": "slot_1"}),
)


class Watch:
    """Checks the rest of a plan as the plan monitor does."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._reads = Reads()
        self._watches = Watches(world)
        self.close = self._watches.close

    @property
    def stale(self) -> bool:
        return self._reads.stale

    def look(self, running: Sequence[Step], rest: Sequence[Step]) -> Flaw | None:
        self._reads.stale = False
        state = self._world.snapshot()
        check = Check((IN_CONTAINER("ball_1", "slot_1"),), tuple(running), tuple(rest), SKILLS)
        found = check.answer(state, Planners.only(GivenPlanner()), lambda: False)
        self._watches.note(self._reads, found.keys, state.version)
        return found.flaw


checker = Watch


def move(world: World, what: str, relation: str, place: str) -> None:
    with world.transaction("somebody", "moved it") as tx:
        tx.place(what, relation, place)


def test_running_steps_are_assumed_to_succeed() -> None:
    world = tiny_world()

    assert checker(world).look([DRIVING], REST) is None
    flaw = checker(world).look([], REST)
    assert flaw is not None
    assert (flaw.step, flaw.verdict.text) == (0, "At(robot_1, box_a)")


def test_cancelled_steps_are_not_assumed_to_succeed() -> None:
    asked: list[Check] = []
    context: Any = SimpleNamespace(
        world=tiny_world(),
        offers=lambda agent, skill: True,
        planning=SimpleNamespace(ask=lambda check: asked.append(check) or SimpleNamespace(done=lambda: False)),
        wait_in_lockstep=lambda asked, control: None,
    )
    running = [SimpleNamespace(step=step, leaving=why) for step, why in ((DRIVING, ""), (REST[0], "of no use"))]
    monitor = PlanMonitor(context, Control(), (IN_CONTAINER("ball_1", "slot_1"),), SKILLS)

    monitor.check(Progress(running=cast("Any", tuple(running)), rest=REST, done=False), {})

    assert [check.running for check in asked] == [(DRIVING,)]


def test_only_a_change_of_what_was_read_makes_a_plan_check_stale() -> None:
    world = tiny_world()
    watch = checker(world)
    assert watch.stale
    watch.look([DRIVING], REST)

    move(world, "red_ball_1", "sk:in", "box_a")
    assert not watch.stale
    move(world, "ball_1", "sk:in", "box_b")
    assert watch.stale
    flaw = watch.look([DRIVING], REST)
    assert flaw is not None
    assert flaw.verdict.text == "In(ball_1, box_a)"


def test_an_element_that_goes_is_heard_of() -> None:
    world = tiny_world()
    watch = checker(world)
    watch.look([DRIVING], REST)
    with world.transaction("somebody", "threw it away") as tx:
        tx.remove("ball_1")

    assert watch.stale
    assert watch.look([DRIVING], REST) is not None


def test_a_closed_plan_checker_receives_no_changes() -> None:
    world = tiny_world()
    watch = checker(world)
    watch.look([DRIVING], REST)
    watch.close()
    move(world, "ball_1", "sk:in", "box_b")

    assert not watch.stale


def test_assumed_effects_do_not_change_the_world_and_keep_the_numbers_that_robots_reached() -> None:
    world = tiny_world()
    version = world.version
    overlay, reached = supposing(world, [DRIVING, REST[0]], SKILLS, {"robot_1": 2})

    assert overlay.related("ball_1", "sk:heldBy", "gripper_1")
    assert world.version == version
    assert reached == {"robot_1": 2}, "nothing here has a number"
