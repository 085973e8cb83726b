"""The small version of ``benchmarks/explanation.py``: tasks spoilt in a known way, and what is said of them."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from mutations import Mutation, mutations

from skiros_py.planning.explanation.explaining import explain
from skiros_py.planning.explanation.trial import Trial
from skiros_py.planning.planners.kairos import Kairos
from skiros_py.planning.planners.planner import Planners
from skiros_py.planning.problem.task import build_task

SPOILT = list(mutations(seed=7, rounds=1))


@pytest.fixture(scope="module")
def planners() -> Iterator[Planners]:
    found = Planners.only(Kairos())
    yield found
    found.close()


@pytest.mark.parametrize("mutation", SPOILT, ids=lambda m: m.name)
def test_the_cause_is_the_mutation_of_the_task_and_every_repair_works(mutation: Mutation, planners: Planners) -> None:
    trial = Trial(planners, mutation.capabilities, each=30.0, together=300.0)
    before = mutation.world.version

    found = explain(build_task(mutation.world, mutation.capabilities, mutation.goal), trial)

    assert mutation.is_explained(found.causes), found.reasons
    assert mutation.world.version == before
    for repair in found.repairs:
        assert mutation.again is not None
        fresh = mutation.again()
        repair.apply(fresh.world)
        goal = [condition for condition in fresh.goal if condition not in repair.without]
        if repair.edits or repair.without:
            assert goal
            assert trial(fresh.world, goal), repair.text


def test_a_seed_always_gives_the_same_tasks() -> None:
    again = list(mutations(seed=7, rounds=1))

    assert [(m.name, m.goal, m.expected) for m in again] == [(m.name, m.goal, m.expected) for m in SPOILT]


def test_the_goal_without_the_mutated_conditions_is_reachable(planners: Planners) -> None:
    """The rest of the goal can be reached: what was spoilt is the only thing that is wrong."""
    for mutation in SPOILT:
        rest = [condition for condition in mutation.goal if condition not in mutation.spoilt]
        if rest:
            trial = Trial(planners, mutation.capabilities, each=30.0)
            assert trial(mutation.world, rest), mutation.name
