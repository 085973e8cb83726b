"""Planners that take long or fail: what is asked next, what is proved without them, and that nobody waits for them."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import closing
from dataclasses import replace
from itertools import count

import pytest
from support.battery import battery_world, charging, driving

from skiros_py.errors import PlanningError
from skiros_py.planning.explanation.trial import Trial
from skiros_py.planning.plan import NoPlan, Plan
from skiros_py.planning.planners.planner import Answer, Planner, Planners, Unsolvable, wait_for
from skiros_py.planning.problem.task import Capability
from skiros_py.planning.process import ThreadHost
from skiros_py.planning.requests import PlanRequest
from skiros_py.planning.service import Planned, SolverLoop, plan
from skiros_py.ports.values import Pending
from skiros_py.skills.conditions import Computed, Condition, Verdict
from skiros_py.testing import SKILLS, GivenPlanner, tiny_world
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, FITS, IN_CONTAINER, PICK, PLACE
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import AT
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


def planning(world: World, planner: Planner, goal: Sequence[Condition]) -> Planned:
    return plan(planner, world, able(world), goal)


def test_a_known_impossibility_is_reported_even_if_the_planner_never_answers() -> None:
    planner = Failing(*RIGHT, times=1)
    outcome = planning(tiny_world(*MUCH), planner, THREE_IN_ONE).outcome

    assert isinstance(outcome, NoPlan)
    assert "slot_1 takes one" in outcome.reasons[0]
    assert planner.calls[0].cancelled


@pytest.mark.parametrize("facts", [MUCH, []], ids=["much", "little"])
def test_a_known_impossibility_is_reported_even_if_all_planners_fail(facts: list[str]) -> None:
    goal = IN_CONTAINER("ball_1", "slot_1"), IN_CONTAINER("red_ball_1", "slot_1")
    outcome = planning(tiny_world(*facts), Failing(times=1000, error="found no answer in 3 s"), goal).outcome

    assert isinstance(outcome, NoPlan)
    assert "slot_1 takes one" in outcome.reasons[0]


def test_without_a_known_cause_failing_planners_are_reported_as_a_planner_fault() -> None:
    goal = (IN_CONTAINER("ball_1", "slot_1"),)

    with pytest.raises(PlanningError, match="found no answer in 3 s"):
        planning(tiny_world(*MUCH), Failing(times=1000, error="found no answer in 3 s"), goal)


def test_a_failure_with_few_candidates_is_retried_with_more() -> None:
    goal = (IN_CONTAINER("ball_1", "slot_1"),)
    planned = planning(tiny_world(*MUCH), Failing(*RIGHT, times=1, error="crashed"), goal)

    assert isinstance(planned.outcome, Plan)
    assert planned.notes == ("crashed",)


def test_a_slow_planner_with_few_candidates_is_stopped_and_retried_with_more() -> None:
    world = tiny_world(*MUCH)
    slow = Failing(*RIGHT, times=1)
    loop = SolverLoop(Planners.only(slow), world, able(world), (IN_CONTAINER("ball_1", "slot_1"),), hurry=0.05)
    (few, few_texts), *_, (whole, texts) = loop.attempts()

    first = loop.solve(few, few_texts)
    second = loop.solve(whole, texts)

    assert first.plan is None
    assert not first.is_about(few_texts)
    assert loop.notes == ["given found no plan with what is nearest in 0.05 s"]
    assert slow.calls[0].cancelled
    assert second.plan is not None


def test_failures_of_planners_asked_for_a_part_of_the_goal_are_noted() -> None:
    world = tiny_world(robots=2)
    planned = planning(world, Failing(*RIGHT, times=1, error="crashed"), (IN_CONTAINER("ball_1", "slot_1"),))

    assert isinstance(planned.outcome, Plan)
    assert planned.notes == ("crashed",)


def test_a_part_of_the_goal_that_cannot_be_written_as_pddl_does_not_end_planning() -> None:
    def fits(view: WorldView, ball: str, slot: str) -> Verdict:
        if "floor" in view.objects("robot_1", AT):
            raise ValueError(f"nothing is known of {ball} and {slot} from there")
        return Verdict(True, "")

    word = replace(FITS, pattern=Computed("tiny:fitsIn", "ball", "slot", fits))
    asking = replace(PLACE, pre=tuple(word(*c.arguments) if c.type is FITS else c for c in PLACE.pre))
    world = tiny_world(robots=2)
    skills = [Capability(skill, world.instances(skill.agent_class)) for skill in (DRIVE, PICK, asking)]
    planned = plan(GivenPlanner(*RIGHT), world, skills, (IN_CONTAINER("ball_1", "slot_1"),))

    assert isinstance(planned.outcome, Plan)
    assert "nothing is known of ball_1 and slot_1 from there" in planned.notes[0]


def test_a_search_that_may_never_end_is_given_up_and_the_missing_limit_is_named() -> None:
    slow, world = Failing(times=1000), battery_world(20.0)
    slow.supports = frozenset({":typing", ":numeric-fluents"})
    skills = (driving(), PICK, PLACE, charging(None, None))
    able_ = tuple(Capability(skill, world.instances(skill.agent_class)) for skill in skills)
    loop = SolverLoop(Planners.only(slow), world, able_, (IN_CONTAINER("ball_1", "slot_1"),), hurry=0.05)

    with pytest.raises(PlanningError, match="nothing limits how far skill 'recharge' increases the charge"):
        loop.plan()
    assert slow.calls[0].cancelled


# ------------------------------------------------------------------ stopping


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


def test_a_trial_waits_for_the_planner_until_it_is_cancelled() -> None:
    world, looks = tiny_world(), count()
    patient = Trial(Planners.only(Later(50)), able(world), each=60.0)
    stopped = Trial(Planners.only(Later(10**9)), able(world), each=60.0, stopped=lambda: next(looks) > 20)

    assert patient(world, (IN_CONTAINER("ball_1", "slot_1"),)) is False
    with pytest.raises(PlanningError, match="needs no more"):
        stopped(world, (IN_CONTAINER("ball_1", "slot_1"),))


def test_a_cancelled_request_ends_the_call_of_the_planner() -> None:
    planner, world = Failing(times=1000), tiny_world()
    with closing(ThreadHost(world, planner)) as host:
        asked = host.ask(PlanRequest((IN_CONTAINER("ball_1", "slot_1"),), able(world)))
        while not planner.calls:
            time.sleep(0.001)
        asked.cancel()
        with pytest.raises(PlanningError, match="stopped"):
            asked.result()

    assert all(call.cancelled for call in planner.calls)


@pytest.mark.parametrize(("rounds", "steps"), [(20, 4), (200, 404)])
def test_detours_are_searched_only_in_plans_of_moderate_length(rounds: int, steps: int) -> None:
    there_and_back = "drive base_1 robot_1 box_b box_a", "drive base_1 robot_1 box_a box_b"
    answer = GivenPlanner(RIGHT[0], *there_and_back * rounds, *RIGHT[1:], "drive base_1 robot_1 box_b box_a")
    goal = IN_CONTAINER("ball_1", "slot_1"), AT_LOCATION("robot_1", "box_b")
    outcome = planning(tiny_world(), answer, goal).outcome

    assert isinstance(outcome, Plan)
    assert len(outcome.steps) == steps


class Arriving:
    """A pending answer that arrives when it is waited for."""

    latency = 0.0

    def __init__(self) -> None:
        self.waited: list[float] = []
        self.cancelled = False

    def done(self) -> bool:
        return bool(self.waited)

    def wait(self, seconds: float) -> None:
        self.waited.append(seconds)

    def result(self) -> Answer:
        return Unsolvable()

    def cancel(self) -> None:
        self.cancelled = True


def test_an_answer_that_can_be_waited_for_is_not_polled():
    pending = Arriving()

    assert wait_for(pending, lambda _taken: None) == Unsolvable()
    assert len(pending.waited) == 1


def test_an_answer_that_is_no_longer_needed_is_cancelled():
    pending = Arriving()

    def refuse(_taken: float) -> None:
        raise PlanningError("enough")

    with pytest.raises(PlanningError, match="enough"):
        wait_for(pending, refuse)

    assert pending.cancelled
    assert not pending.waited
