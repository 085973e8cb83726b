"""unified-planning's engines behind the port. Its import takes seconds: only few claims."""

from __future__ import annotations

import pytest
from support.planning import tiny_pddl

from skiros_py.errors import PlanningError
from skiros_py.planning.planners.planner import Solved
from skiros_py.planning.planners.unified import UnifiedPlanning
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import IN_CONTAINER


def test_several_tasks_at_once_each_get_their_own_plan() -> None:
    """Called as it is, it gave most of them another's plan."""
    texts = [tiny_pddl(tiny_world(), IN_CONTAINER("ball_1", slot)) for slot in ("slot_1", "slot_2")]
    planner = UnifiedPlanning()

    answers = [pending.result() for pending in [planner.solve(t.domain, t.problem) for t in texts]]
    planner.close()

    placed = [answer.steps[-1][-1] for answer in answers if isinstance(answer, Solved)]
    assert placed == ["slot_1", "slot_2"]


def test_an_unknown_engine_is_answered_with_the_known_ones() -> None:
    planner = UnifiedPlanning("warp")
    texts = tiny_pddl(tiny_world(), IN_CONTAINER("ball_1", "slot_1"))

    with pytest.raises(PlanningError, match=r"has no engine 'warp' here; it has .*fast-downward"):
        planner.solve(texts.domain, texts.problem).result()
    planner.close()
