"""Planners that take long or fail: what is asked next, what is proved without them, and that nobody waits for them."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from contextlib import closing

import pytest

from skiros_py.errors import PlanningError
from skiros_py.planning.asking import Asking
from skiros_py.planning.attempts import Wanted, attempts
from skiros_py.planning.explanation import Trial
from skiros_py.planning.pieces import Work, at_once, in_slices
from skiros_py.planning.plan import NoPlan, Plan
from skiros_py.planning.planners.choosing import Planners
from skiros_py.planning.planners.planner import Answer, Planner
from skiros_py.planning.problem.task import Capability
from skiros_py.planning.prospect import Prospect
from skiros_py.planning.service import Planned, PlanningService
from skiros_py.ports.pending import Pending
from skiros_py.skills.conditions import Condition
from skiros_py.testing import SKILLS, GivenPlanner, tiny_world
from skiros_py.testing.tiny_skills import AT_LOCATION, IN_CONTAINER
from skiros_py.world.world import World

MUCH = [f"scene:ball_{n} a tiny:Ball ; sk:in scene:box_a ." for n in range(2, 80)]
THREE_IN_ONE = tuple(IN_CONTAINER(f"ball_{n}", "slot_1") for n in (1, 2, 3))
RIGHT = (
    "drive base_1 robot_1 box_a unknown_location",
    "pick arm_1 gripper_1 robot_1 box_a ball_1",
    "place arm_1 gripper_1 robot_1 ball_1 slot_1",
)


class Never:
    """An answer that never comes."""

    latency = 0.0
    cancelled = False

    def done(self) -> bool:
        return False

    def result(self) -> Answer:
        raise AssertionError("nobody may ask for it")

    def cancel(self) -> None:
        self.cancelled = True


class Failing(GivenPlanner):
    """Fails, or never answers, so many times; then it answers."""

    def __init__(self, *steps: str, times: int, error: str = "") -> None:
        super().__init__(*steps)
        self.calls: list[Never] = []
        self._times = times
        self._error = error

    def solve(self, domain: str, problem: str) -> Pending[Answer]:  # type: ignore[override]
        if len(self.calls) == self._times:
            return super().solve(domain, problem)
        self.calls.append(Never())
        if self._error:
            raise PlanningError(self._error)
        return self.calls[-1]


def able(world: World) -> tuple[Capability, ...]:
    return tuple(Capability(s.description, world.instances(s.description.agent_class)) for s in SKILLS)


def planning(
    world: World, planner: Planner, goal: Sequence[Condition], *, lockstep: bool = True
) -> Generator[None, None, Planned]:
    return PlanningService(planner, lockstep=lockstep).plan(world, able(world), goal)


@pytest.mark.parametrize("lockstep", [True, False])
def test_what_is_known_to_be_impossible_is_said_though_the_planner_never_answers(lockstep: bool) -> None:
    planner = Failing(*RIGHT, times=1)
    outcome = at_once(planning(tiny_world(*MUCH), planner, THREE_IN_ONE, lockstep=lockstep)).outcome

    assert isinstance(outcome, NoPlan)
    assert "slot_1 takes one" in outcome.reasons[0]
    assert planner.calls[0].cancelled


@pytest.mark.parametrize("facts", [MUCH, []], ids=["much", "little"])
def test_what_is_known_to_be_impossible_is_said_though_all_planners_fail(facts: list[str]) -> None:
    goal = IN_CONTAINER("ball_1", "slot_1"), IN_CONTAINER("red_ball_1", "slot_1")
    outcome = at_once(planning(tiny_world(*facts), Failing(times=1000, error="found no answer in 3 s"), goal)).outcome

    assert isinstance(outcome, NoPlan)
    assert "slot_1 takes one" in outcome.reasons[0]


def test_where_planners_fail_and_nothing_is_known_it_is_their_fault() -> None:
    goal = (IN_CONTAINER("ball_1", "slot_1"),)

    with pytest.raises(PlanningError, match="found no answer in 3 s"):
        at_once(planning(tiny_world(*MUCH), Failing(times=1000, error="found no answer in 3 s"), goal))


def test_a_failure_with_a_few_candidates_lets_more_be_tried() -> None:
    planned = at_once(
        planning(tiny_world(*MUCH), Failing(*RIGHT, times=1, error="crashed"), (IN_CONTAINER("ball_1", "slot_1"),))
    )

    assert isinstance(planned.outcome, Plan)
    assert planned.notes == ("crashed",)


def test_a_planner_that_takes_long_with_a_few_candidates_is_stopped_and_asked_with_more() -> None:
    world = tiny_world(*MUCH)
    wanted = Wanted(world, able(world), (IN_CONTAINER("ball_1", "slot_1"),))
    (few, few_texts), *_, (whole, texts) = (attempt for attempt in attempts(wanted) if attempt is not None)
    slow = Failing(*RIGHT, times=1)
    asking = Asking(Planners.only(slow), lockstep=True, hurry=0.05)
    notes: list[str] = []

    first = at_once(asking.found(wanted, few, few_texts, Prospect(wanted), notes))
    second = at_once(asking.found(wanted, whole, texts, Prospect(wanted), notes))

    assert first.plan is None
    assert not first.is_about(few_texts)
    assert notes == ["given found no plan with what is nearest in 0.05 s"]
    assert slow.calls[0].cancelled
    assert second.plan is not None


# ------------------------------------------------------------------ nobody waits


def test_planning_lets_others_go_on_between_its_pieces() -> None:
    work = planning(tiny_world(*MUCH), GivenPlanner(*RIGHT), (IN_CONTAINER("ball_1", "slot_1"),), lockstep=False)

    assert len(list(work)) >= 2


def test_while_simulated_time_stands_still_planning_never_yields() -> None:
    work = planning(tiny_world(*MUCH), GivenPlanner(*RIGHT), (IN_CONTAINER("ball_1", "slot_1"),))

    assert list(work) == []


class Later(GivenPlanner):
    """Answers when it was looked for the answer so many times."""

    def __init__(self, looks: int) -> None:
        super().__init__()
        self.looks = looks

    def solve(self, domain: str, problem: str) -> Pending[Answer]:  # type: ignore[override]
        planner, given = self, super().solve(domain, problem)

        class Waiting(Never):
            def done(self) -> bool:
                planner.looks -= 1
                return planner.looks < 0

            def result(self) -> Answer:
                return given.result()

        return Waiting()


def test_trying_something_out_yields_while_the_planner_works() -> None:
    world = tiny_world()
    trial = Trial(Planners.only(Later(50)), able(world), each=60.0, lockstep=False)

    assert len(list(trial(world, (IN_CONTAINER("ball_1", "slot_1"),)))) >= 50


def test_slices_of_work_give_what_the_whole_work_gives() -> None:
    def work(pieces: int) -> Work[int]:
        for _ in range(pieces):
            yield
        return pieces

    assert at_once(in_slices(work(100), 0.0)) == at_once(work(100)) == 100
    assert len(list(in_slices(work(100), 0.0))) == 100
    assert list(in_slices(work(100), 60.0)) == []


def test_a_closed_plan_ends_the_call_of_the_planner() -> None:
    planner = Failing(times=1000)
    with closing(planning(tiny_world(), planner, (IN_CONTAINER("ball_1", "slot_1"),), lockstep=False)) as work:
        for _ in range(100):
            next(work)

    assert planner.calls
    assert all(call.cancelled for call in planner.calls)


@pytest.mark.parametrize(("rounds", "steps"), [(20, 4), (200, 404)])
def test_detours_are_looked_for_in_plans_that_are_not_very_long(rounds: int, steps: int) -> None:
    there_and_back = "drive base_1 robot_1 box_b box_a", "drive base_1 robot_1 box_a box_b"
    answer = GivenPlanner(RIGHT[0], *there_and_back * rounds, *RIGHT[1:], "drive base_1 robot_1 box_b box_a")
    goal = IN_CONTAINER("ball_1", "slot_1"), AT_LOCATION("robot_1", "box_b")
    outcome = at_once(planning(tiny_world(), answer, goal)).outcome

    assert isinstance(outcome, Plan)
    assert len(outcome.steps) == steps
