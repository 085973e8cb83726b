"""Claims about the sampling planners, in a plane with walls."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from skiros_py.geometry import Array
from skiros_py.motion.sampling import Est, Prm, RrtConnect
from skiros_py.ports.motion import SamplingPlanner, SearchTask

PLANNERS = [RrtConnect(), Prm(), Est()]
START, GOAL = np.array([-2.0, 0.0]), np.array([2.0, 0.0])


def wall_with_a_door(posture: Array) -> bool:
    x, y = posture
    return bool(abs(x) > 0.2 or 1.5 < y < 2.1)


def closed_wall(posture: Array) -> bool:
    return bool(abs(posture[0]) > 0.2)


def task(
    clear: Callable[[Array], bool], *, seed: int = 0, iterations: int = 3000, band: float | None = None
) -> SearchTask:
    def keeps(posture: Array) -> bool:
        return band is None or abs(posture[1] - circle(posture[0])) <= band

    def circle(x: float) -> float:
        return float(np.sqrt(max(0.0, 4.0 - x**2)))

    def project(posture: Array) -> Array | None:
        if keeps(posture):
            return posture
        return np.array([posture[0], circle(posture[0])]) if abs(posture[0]) <= 2.0 else None

    def both(posture: Array) -> bool:
        return clear(posture) and keeps(posture)

    def straight(one: Array, other: Array) -> bool:
        return all(both(one + share * (other - one)) for share in np.linspace(0.0, 1.0, 40))

    return SearchTask(
        START, GOAL, np.full(2, -3.0), np.full(2, 3.0), both, straight, project, band is not None,
        (), None, 0.0, 0.0, iterations, seed,
    )  # fmt: skip


@pytest.mark.parametrize("planner", PLANNERS, ids=lambda planner: planner.name)
@pytest.mark.parametrize("seed", range(5))
def test_a_path_leads_through_the_door_in_clear_straight_lines(planner: SamplingPlanner, seed: int) -> None:
    problem = task(wall_with_a_door, seed=seed)

    path = planner.search(problem)

    assert path is not None
    assert np.array_equal(path[0], START)
    assert np.array_equal(path[-1], GOAL)
    assert all(problem.straight(one, other) for one, other in pairwise(path))


@pytest.mark.parametrize("planner", PLANNERS, ids=lambda planner: planner.name)
def test_the_same_seed_gives_the_same_path_and_another_seed_another(planner: SamplingPlanner) -> None:
    one, again, other = (planner.search(task(wall_with_a_door, seed=seed)) for seed in (3, 3, 4))

    assert one is not None
    assert again is not None
    assert other is not None
    assert np.array_equal(one, again)
    assert not (len(one) == len(other) and np.array_equal(one, other))


@pytest.mark.parametrize("planner", PLANNERS, ids=lambda planner: planner.name)
def test_where_there_is_no_way_a_search_ends_after_its_samples(planner: SamplingPlanner) -> None:
    assert planner.search(task(closed_wall, iterations=200)) is None


@pytest.mark.parametrize("planner", [RrtConnect(), Prm()], ids=lambda planner: planner.name)
def test_samples_are_brought_to_where_a_constraint_holds(planner: SamplingPlanner) -> None:
    """The path has to follow half a circle that covers a hundredth of the plane."""
    problem = task(lambda _posture: True, band=0.05)

    path = planner.search(problem)

    assert path is not None
    assert all(problem.straight(one, other) for one, other in pairwise(path))
    assert max(posture[1] for posture in path) > 1.7


def test_rrt_connect_gives_up_early_where_an_end_is_boxed_in() -> None:
    drawn: list[Array] = []

    def noted(posture: Array) -> Array:
        drawn.append(posture)
        return posture

    problem = task(lambda posture: bool(np.abs(posture - START).max() < 0.1))

    assert RrtConnect().search(replace(problem, project=noted)) is None
    assert len(drawn) < problem.iterations / 4
