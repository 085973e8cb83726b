"""Derives which steps of a plan have to wait for which others, and when each can start.

A plan comes as a sequence. Two steps may run concurrently, or swap, unless one writes what the other
reads or writes, or both need the same device.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from graphlib import TopologicalSorter
from math import prod

from skiros_py.planning.domain.model import Atom, Grounding, NoneSuch
from skiros_py.planning.domain.numbers import change_of, number_compared
from skiros_py.planning.plan import Plan
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.replay import replay
from skiros_py.skills.parameters import Kind
from skiros_py.skills.skill import SkillDescription

Order = tuple[frozenset[int], ...]
"""For each step the indices of the steps that must have ended before it starts; without transitive ones."""


def order(task: PlanningTask, plan: Plan) -> Plan:
    """Returns a plan with its partial order, its chance, and with times if all step durations are known.

    It stays strictly sequential if no other order can be derived.

    The order comes from the actions of the task. Conditions may depend on more than these (reasoner results are frozen
    at the start), so the sequence that departs most from the given one is replayed before the order is accepted.

    Args:
        task: The planned task.
        plan: The steps, validated by replay, and their actions.
    """
    after = partial_order(plan.groundings, task.skills)
    if len(after) != len(plan.steps):
        return plan
    other = tuple(plan.steps[index] for index in contrary(after))
    if other != plan.steps and replay(task.view, other, task.conditions, task.skills) is not None:
        return plan
    durations = [one.action.seconds(one.binding) for one in plan.groundings if one.action.skill is not None]
    known = [seconds for seconds in durations if seconds is not None]
    learned = [one.action.costs(one.binding) for one in plan.groundings if one.action.costs is not None]
    chance = prod(one.chance for one in learned if one is not None) if any(learned) else None
    if len(known) < len(durations):
        return replace(plan, after=after, chance=chance)
    starts = schedule(after, known)
    seconds = max((start + lasts for start, lasts in zip(starts, known, strict=True)), default=0.0)
    return replace(plan, after=after, starts=starts, seconds=seconds, chance=chance)


def partial_order(plan: Sequence[Grounding], skills: Mapping[str, SkillDescription]) -> Order:
    """Orders the skills of a plan; every sequence consistent with it has the same result as the plan.

    Args:
        plan: The actions; bookkeeping is skipped.
        skills: The skill descriptions, which state the device parameters.
    """
    actions = [Effect.of(one, skills) for one in plan]
    changing = frozenset(atom for action in actions for atom in action.writes)
    actions = [replace(action, reads=action.reads & changing) for action in actions]  # what only is read orders nothing
    before: list[int] = []  # for each action those that precede it, as bits
    for index, action in enumerate(actions):
        known = 0
        for earlier in reversed(range(index)):
            if not known >> earlier & 1 and _interfere(actions[earlier], action):
                known |= before[earlier] | 1 << earlier
        before.append(known)
    steps = [index for index, one in enumerate(plan) if one.action.skill is not None]
    return tuple(_nearest(index, steps, before) for index in steps)


def _nearest(index: int, steps: Sequence[int], before: Sequence[int]) -> frozenset[int]:
    """The steps before one that are not before another of them, numbered among the steps."""
    found, known = [], 0
    for number, earlier in reversed(list(enumerate(steps))):
        if before[index] >> earlier & 1 and not known >> earlier & 1:
            found.append(number)
            known |= before[earlier]
    return frozenset(found)


# ------------------------------------------------------------ what an action reads and writes


@dataclass(frozen=True, slots=True)
class Effect:
    """What one action of the plan reads and writes, and the devices it needs."""

    reads: frozenset[Atom]
    adds: frozenset[Atom]
    deletes: frozenset[Atom]
    none: tuple[NoneSuch, ...]
    devices: frozenset[str]

    @classmethod
    def of(cls, one: Grounding, skills: Mapping[str, SkillDescription]) -> Effect:
        """Returns the effect of an action with its elements."""
        action, binding = one.action, one.binding
        params = () if action.skill is None else skills[action.skill].params
        devices = (binding.get("?" + param.key) for param in params if param.kind is Kind.HARDWARE)
        adds = one.of(action.add)
        none = tuple(_with_numbers(such.bind(binding)) for such in action.none)
        deletes = one.of(action.delete) - adds
        changes = [(change_of(atom), atom.arguments) for atom in one.of(action.changes)]
        changed = {Atom(property_, elements[:1]) for (_, property_, _), elements in changes}
        amounts = {Atom(by, elements[-1:]) for (_, _, by), elements in changes if isinstance(by, str)}
        # changes of one number keep their order: each starts from the last
        reads = one.of(action.pre) | {*_numbers(one.of(action.pre))} | changed | amounts
        return cls(reads, adds | changed, deletes, none, frozenset(filter(None, devices)))

    @property
    def writes(self) -> frozenset[Atom]:
        """The facts it changes."""
        return self.adds | self.deletes


def _numbers(atoms: Iterable[Atom]) -> Iterator[Atom]:
    """Yields the numbers that some atoms compare, as what changes them writes them."""
    compared = ((number_compared(atom.predicate), atom.arguments) for atom in atoms)
    yield from (Atom(number[0], arguments) for number, arguments in compared if number is not None)


def _with_numbers(such: NoneSuch) -> NoneSuch:
    return replace(such, atoms=(*such.atoms, *_numbers(such.atoms)))


def _interfere(one: Effect, other: Effect) -> bool:
    """Returns whether two actions must not be swapped."""
    return not (
        one.writes.isdisjoint(other.reads)
        and one.reads.isdisjoint(other.writes)
        and one.adds.isdisjoint(other.deletes)
        and one.deletes.isdisjoint(other.adds)
        and one.devices.isdisjoint(other.devices)
        and not _touches(one, other.none)
        and not _touches(other, one.none)
    )


def _touches(action: Effect, none: Sequence[NoneSuch]) -> bool:
    """Returns whether an action writes anything that others require to be absent."""
    return any(_matches(wanted, atom) for such in none for wanted in such.atoms for atom in action.writes)


def _matches(wanted: Atom, atom: Atom) -> bool:
    pairs = zip(wanted.arguments, atom.arguments, strict=False)
    return wanted.predicate == atom.predicate and all(a.startswith("?") or a == b for a, b in pairs)


# ------------------------------------------------------------ orders as sequences and in time


def contrary(after: Order) -> tuple[int, ...]:
    """Returns the steps in the sequence that respects an order but departs most from the given one: last steps first.

    >>> contrary((frozenset(), frozenset({0}), frozenset()))
    (2, 0, 1)
    """
    sorter = TopologicalSorter(dict(enumerate(after)))
    sorter.prepare()
    ready: list[int] = []  # as a heap, the last at its front
    taken: list[int] = []
    while sorter.is_active():
        for index in sorter.get_ready():
            heapq.heappush(ready, -index)
        taken.append(-heapq.heappop(ready))
        sorter.done(taken[-1])
    return tuple(taken)


def schedule(after: Order, durations: Sequence[float]) -> tuple[float, ...]:
    """Returns the start time of each step [s] if all start as early as possible.

    >>> schedule((frozenset(), frozenset({0}), frozenset()), [2.0, 1.0, 5.0])
    (0.0, 2.0, 0.0)

    Args:
        after: The order; no step waits for a later one.
        durations: How long each step takes [s].
    """
    starts: list[float] = []
    for waits in after:
        starts.append(max((starts[i] + durations[i] for i in waits), default=0.0))
    return tuple(starts)
