from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.planning import tiny_task

from skiros_py.errors import DescriptionError
from skiros_py.planning.durations import KEPT, duration_of, observe, timed
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import AT_LOCATION, DRIVE
from skiros_py.world.vocabulary import LEARNED_DURATION
from skiros_py.world.world import World

DECLARED = replace(DRIVE, duration=20.0)


def ran(world: World, seconds: float, skill: str = "drive", agent: str = "base_1") -> None:
    observe(world, skill, agent, seconds)


def test_a_declared_duration_is_used_until_one_is_learned() -> None:
    world = tiny_world()

    assert duration_of(world, DECLARED, "sk:Base") == 20.0
    assert duration_of(world, DRIVE, "sk:Base") is None
    ran(world, 12.0)
    assert duration_of(world, DECLARED, "sk:Base") == 12.0


@given(st.lists(st.floats(0.5, 100.0), min_size=1, max_size=2 * KEPT))
def test_the_median_of_the_last_runs_counts(times: list[float]) -> None:
    world = tiny_world()
    for seconds in times:
        ran(world, seconds)
    last = sorted(times[-KEPT:])
    learned = duration_of(world, DECLARED, "sk:Base")

    assert learned == pytest.approx((last[(len(last) - 1) // 2] + last[len(last) // 2]) / 2)
    assert len(world.abstracts(LEARNED_DURATION)) == 1


@pytest.mark.parametrize(("seconds", "agent"), [(0.0, "base_1"), (9.0, "gone")])
def test_invalid_runs_change_no_learned_duration(seconds: float, agent: str) -> None:
    world = tiny_world()
    before = world.version

    ran(world, seconds, agent=agent)

    assert duration_of(world, DECLARED, "sk:Base") == 20.0
    assert world.version == before


def test_each_skill_and_agent_class_has_its_own_durations() -> None:
    world = tiny_world()
    ran(world, 4.0)
    ran(world, 7.0, skill="push")
    ran(world, 9.0, agent="arm_1")

    assert duration_of(world, DECLARED, "sk:Base") == 4.0
    assert duration_of(world, DECLARED, "sk:Arm") == 9.0
    assert duration_of(world, replace(DECLARED, name="push"), "sk:Base") == 7.0


def test_a_task_contains_the_durations_of_its_actions() -> None:
    world = tiny_world()
    ran(world, 4.0)
    task = timed(tiny_task(world, AT_LOCATION("robot_1", "box_a"), skills=[DECLARED]))

    assert [action.duration for action in task.domain.actions if action.skill == "drive"] == [4.0]


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("inf"), float("nan")])
def test_an_invalid_duration_is_refused(seconds: float) -> None:
    with pytest.raises(DescriptionError, match="duration of skill 'drive'"):
        replace(DRIVE, duration=seconds)
