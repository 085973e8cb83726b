from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from support.planning import tiny_task

from skiros_py.planning.domain.model import Action, Atom, NoneSuch, Variable
from skiros_py.planning.domain.pddl import NameMap, PddlTexts, write_pddl
from skiros_py.planning.experience import timed
from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.plan_validation import grounded
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.replay import replay
from skiros_py.planning.robots.ordering import contrary, order, partial_order, schedule
from skiros_py.skills.conditions import Condition
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, IN_CONTAINER, PICK, PLACE

SKILLS = {skill.name: skill for skill in (DRIVE, PICK, PLACE)}
WORLD = tiny_world(
    *(f"scene:ball_{n} a tiny:Ball ; sk:in scene:box_{'ab'[n % 2]} ." for n in (2, 3, 4)),
    *(f'scene:slot_{n} a tiny:Slot ; rdfs:label "slot {n}" ; sk:on scene:floor .' for n in (3, 4)),
    robots=2,
)
BALLS = {"ball_1": "box_a", "ball_2": "box_a", "ball_3": "box_b", "ball_4": "box_a"}


def drive(robot: int, location: str) -> Step:
    return Step("drive", {"Base": f"base_{robot}", "Robot": f"robot_{robot}", "Location": location})


def pick(robot: int, ball: str, box: str) -> Step:
    return Step("pick", {**hand(robot), "Box": box, "Ball": ball})


def place(robot: int, ball: str, slot: str) -> Step:
    return Step("place", {**hand(robot), "Ball": ball, "Slot": slot})


def hand(robot: int) -> dict[str, str]:
    return {"Arm": f"arm_{robot}", "Gripper": f"gripper_{robot}", "Robot": f"robot_{robot}"}


def delivery(robot: int, ball: str, slot: str) -> list[Step]:
    return [drive(robot, BALLS[ball]), pick(robot, ball, BALLS[ball]), place(robot, ball, slot)]


def ordered(steps: Sequence[Step], *goal: Condition) -> tuple[Plan, PlanningTask, PddlTexts]:
    task = tiny_task(WORLD, *goal)
    texts = write_pddl(task.domain, task.problem, name="tiny")
    plan = Plan(tuple(steps), grounded(task, steps))
    return order(task, plan), task, texts


def test_dependent_steps_of_one_robot_stay_in_order() -> None:
    plan, _, _ = ordered(delivery(1, "ball_1", "slot_1"), IN_CONTAINER("ball_1", "slot_1"))

    assert plan.after == (frozenset(), frozenset({0}), frozenset({1}))


def test_independent_steps_of_two_robots_run_in_parallel() -> None:
    steps = [*delivery(1, "ball_1", "slot_1"), *delivery(2, "ball_3", "slot_2")]
    plan, _, _ = ordered(steps, IN_CONTAINER("ball_1", "slot_1"), IN_CONTAINER("ball_3", "slot_2"))

    assert plan.after[:3] == (frozenset(), frozenset({0}), frozenset({1}))
    assert plan.after[3:] == (frozenset(), frozenset({3}), frozenset({4}))


def test_a_robot_leaves_a_place_only_after_the_steps_that_need_it_there() -> None:
    steps = [*delivery(1, "ball_1", "slot_1"), drive(1, "box_b")]
    plan, _, _ = ordered(steps, IN_CONTAINER("ball_1", "slot_1"), AT_LOCATION("robot_1", "box_b"))

    assert plan.after[3] == {1}, "once picked, the ball may be placed from anywhere"


def test_goal_bookkeeping_adds_no_ordering() -> None:
    steps = [*delivery(1, "ball_1", "slot_1"), *delivery(2, "ball_3", "slot_2")]
    plan, task, _ = ordered(steps, IN_CONTAINER("tiny:Ball", "slot_1"), IN_CONTAINER("tiny:Ball", "slot_2"))

    assert any(action.skill is None for action in task.domain.actions)
    assert len(plan.after) == len(steps)
    assert plan.after[3] == frozenset()


def test_a_plan_has_start_times_if_all_durations_are_known() -> None:
    steps = [*delivery(1, "ball_1", "slot_1"), *delivery(2, "ball_3", "slot_2")]
    goal = IN_CONTAINER("ball_1", "slot_1"), IN_CONTAINER("ball_3", "slot_2")
    task = tiny_task(WORLD, *goal, skills=[replace(skill, duration=2.0) for skill in SKILLS.values()])
    task = timed(task)
    plan = order(task, Plan(tuple(steps), grounded(task, steps)))

    assert plan.starts == (0.0, 2.0, 4.0, 0.0, 2.0, 4.0)
    assert ordered(steps, *goal)[0].starts == ()


def test_a_plan_without_its_actions_stays_strictly_sequential() -> None:
    task = tiny_task(WORLD, IN_CONTAINER("ball_1", "slot_1"))
    plan = Plan(tuple(delivery(1, "ball_1", "slot_1")))

    assert order(task, plan) is plan
    assert plan.order == (frozenset(), frozenset({0}), frozenset({1}))


def test_a_partial_order_that_fails_the_conditions_is_discarded() -> None:
    """Actions that hide what the steps need of each other, as those of a task that knows less would."""
    task = tiny_task(WORLD, IN_CONTAINER("ball_1", "slot_1"))
    texts = write_pddl(task.domain, task.problem, name="tiny")
    lines = [f"drive base_{n % 2 + 1} robot_{n % 2 + 1} box_a unknown_location" for n in range(3)]
    plan = Plan(tuple(delivery(1, "ball_1", "slot_1")), tuple(texts.grounding(line.split()) for line in lines))

    assert order(task, plan) is plan


def test_absence_conditions_order_the_steps_that_add_and_remove_things() -> None:
    blocked = NoneSuch((Variable("?any", ""),), (Atom("blocks", ("?any", "?door")),))
    actions = {
        "open": Action("open", "drive", (Variable("?door", ""),), (), (Atom("open", ("?door",)),), (), none=(blocked,)),
        "clear": Action(
            "clear", "drive", (Variable("?x", ""), Variable("?y", "")), (), (), (Atom("blocks", ("?x", "?y")),)
        ),
    }
    given_texts = PddlTexts("", "", NameMap(["ball_1", "box_a", "box_b"]), actions)
    lines = ["clear ball_1 box_a", "open box_a", "open box_b"]
    steps = [given_texts.grounding(line.split()) for line in lines]

    assert partial_order(steps, SKILLS) == (frozenset(), frozenset({0}), frozenset())


# ------------------------------------------------------------ every sequence that keeps to the order is as good

deliveries = st.permutations(sorted(BALLS)).flatmap(
    lambda balls: st.lists(st.sampled_from([1, 2]), min_size=1, max_size=4).map(
        lambda robots: [(r, balls[i], f"slot_{i + 1}") for i, r in enumerate(robots)]
    )
)


def linearisation(after: Sequence[frozenset[int]], seed: int) -> list[int]:
    dice, taken = random.Random(seed), list[int]()
    while len(taken) < len(after):
        taken.append(dice.choice([i for i in range(len(after)) if i not in taken and after[i] <= set(taken)]))
    return taken


def shuffled(chosen: Sequence[tuple[int, str, str]], seed: int) -> list[Step]:
    """The deliveries, those of one robot one after the other, those of different robots mixed."""
    queues = {robot: [s for r, *rest in chosen if r == robot for s in delivery(r, *rest)] for robot in (1, 2)}
    dice, steps = random.Random(seed), list[Step]()
    while any(queues.values()):
        steps.append(queues[dice.choice([robot for robot, queue in queues.items() if queue])].pop(0))
    return steps


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(deliveries, st.integers(0, 2**16))
def test_every_linearisation_of_the_partial_order_reaches_the_goal(
    chosen: list[tuple[int, str, str]], seed: int
) -> None:
    goal = [IN_CONTAINER(ball, slot) for _, ball, slot in chosen]
    plan, task, _ = ordered(shuffled(chosen, seed), *goal)

    assert len(plan.after) == len(plan.steps)
    for draw in range(4):
        sequence = [plan.steps[i] for i in linearisation(plan.after, seed + draw)]
        assert replay(WORLD, sequence, task.conditions, SKILLS) is None


@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.integers(0, 2**16))
def test_all_linearisations_of_a_small_order_reach_the_goal(seed: int) -> None:
    chosen = [(1, "ball_1", "slot_1"), (2, "ball_3", "slot_2")]
    plan, task, _ = ordered(shuffled(chosen, seed), *(IN_CONTAINER(b, s) for _, b, s in chosen))
    kept = [p for p in permutations(range(6)) if all(p.index(e) < p.index(i) for i in range(6) for e in plan.after[i])]

    assert len(kept) == 20, "two chains of three"
    assert all(replay(WORLD, [plan.steps[i] for i in p], task.conditions, SKILLS) is None for p in kept)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(deliveries, st.integers(0, 2**16))
def test_the_partial_order_has_no_redundant_waits(chosen: list[tuple[int, str, str]], seed: int) -> None:
    plan, _, _ = ordered(shuffled(chosen, seed), *(IN_CONTAINER(ball, slot) for _, ball, slot in chosen))
    before: list[set[int]] = []
    for waits in plan.after:
        before.append(set(waits).union(*(before[i] for i in waits)))

    for waits in plan.after:
        assert not any(one in before[other] for one in waits for other in waits)


# ------------------------------------------------------------ schedules

graphs = st.integers(1, 8).flatmap(
    lambda n: st.tuples(
        st.tuples(*(st.frozensets(st.integers(0, max(i - 1, 0)), max_size=2 if i else 0) for i in range(n))),
        st.lists(st.floats(0.0, 10.0), min_size=n, max_size=n),
    )
)


@given(graphs)
def test_a_schedule_respects_the_order_and_no_step_waits_longer_than_needed(
    graph: tuple[tuple[frozenset[int], ...], list[float]],
) -> None:
    after, durations = graph
    starts = schedule(after, durations)
    ends = [s + d for s, d in zip(starts, durations, strict=True)]

    assert list(starts) == [max((ends[e] for e in waits), default=0.0) for waits in after]


@given(graphs)
def test_the_contrary_linearisation_respects_the_order(
    graph: tuple[tuple[frozenset[int], ...], list[float]],
) -> None:
    sequence = contrary(graph[0])

    assert sorted(sequence) == list(range(len(graph[0])))
    assert all(sequence.index(e) < sequence.index(i) for i, waits in enumerate(graph[0]) for e in waits)


def test_the_contrary_linearisation_always_takes_the_last_ready_step() -> None:
    chance = random.Random(1)
    for length in range(30):
        after = tuple(frozenset(e for e in range(i) if chance.random() < 0.1) for i in range(length))
        expected: list[int] = []
        while len(expected) < length:
            expected.append(max(i for i in range(length) if i not in expected and after[i] <= set(expected)))

        assert list(contrary(after)) == expected


def test_a_contrary_linearisation_of_very_many_steps_is_found() -> None:
    assert contrary((frozenset(),) * 50_000)[:2] == (49_999, 49_998)
