"""Control-thread time used by planning in its own process, and the latency of a stop during planning."""

from __future__ import annotations

import threading
import time
from contextlib import closing

from planning_worlds import PART_CLASSES, able, crowded
from table import Figure, in_steps

from skiros_py.planning.plan import Plan
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.planners.planner import Answer, Planner, Planners
from skiros_py.planning.process import PlanningProcess
from skiros_py.planning.requests import Asked, Check, PlanRequest
from skiros_py.ports.values import Pending
from skiros_py.testing import Bench, tiny_world
from skiros_py.world.element import Placement
from skiros_py.world.vocabulary import IN
from skiros_skills.conditions import OBJECT_AT_LOCATION

_CYCLE = 0.005


def figures(rounds: int = 5) -> list[Figure]:
    """Measures both.

    Args:
        rounds: How many plans are made.
    """
    return [
        in_steps("500 parts: planning holds the control thread", _longest_hold(rounds), 11_000),
        in_steps("stop answered in lockstep while planning", _stop_in_lockstep(), 280_000),
    ]


def _longest_hold(rounds: int) -> float:
    """Plans and checks plans like the control thread; returns the maximum processor time of one cycle [s]."""
    world = crowded(parts=500, boxes=50)
    goal = tuple(OBJECT_AT_LOCATION(PART_CLASSES[i], f"kit_1_{'abc'[i]}") for i in range(3))
    holds: list[float] = []

    def ask(request: PlanRequest | Check) -> object:
        started = time.thread_time()
        asked: Asked[object] = host.ask(request)
        holds.append(time.thread_time() - started)
        while not asked.done():
            time.sleep(_CYCLE)
        started = time.thread_time()
        value = asked.result().value
        holds.append(time.thread_time() - started)
        return value

    with closing(PlanningProcess(world, _fast_downward)) as host:
        for turn in range(rounds):
            with world.transaction("benchmark", "something new") as tx:
                tx.add(PART_CLASSES[turn % 4], placement=Placement(IN, "pallet_a"))
            capabilities = tuple(able(world))
            planned = ask(PlanRequest(goal, capabilities))
            outcome = getattr(planned, "outcome", None)
            if not isinstance(outcome, Plan):
                raise SystemExit(f"no plan: {outcome}")
            ask(Check(goal, (), outcome.steps, {c.skill.name: c.skill for c in capabilities}))
    return max(holds)


def _fast_downward() -> Planners:
    return Planners.only(FastDownward())


class _Never:
    latency = 0.0

    def done(self) -> bool:
        return False

    def result(self) -> Answer:
        raise AssertionError("it is never there")


class _Thinking:
    """A planner that never answers."""

    name = "thinking"
    supports = FastDownward.supports

    def solve(self, domain: str, problem: str) -> Pending[Answer]:  # noqa: ARG002 - the port's
        return _Never()

    def close(self) -> None:
        """Does nothing."""


def _thinking() -> Planners:
    planner: Planner = _Thinking()
    return Planners.only(planner)


def _stop_in_lockstep() -> float:
    """Returns the time from the stop to the end of a task that waits for its plan [s]."""
    world = tiny_world()
    with closing(PlanningProcess(world, _thinking)) as host, Bench(world, planning=host) as bench:
        task = bench.tasks.begin(bench.goal("In(ball_1, slot_1)"))
        wished: list[float] = []

        def stop() -> None:
            time.sleep(1.0)
            wished.append(time.perf_counter())
            task.stop("enough")

        thread = threading.Thread(target=stop)
        thread.start()
        while not task.done:
            bench.cycle.step()
        ended = time.perf_counter()
        thread.join()
    return ended - wished[0]
