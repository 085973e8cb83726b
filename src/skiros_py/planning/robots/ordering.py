"""Derives which steps of a plan have to wait for which others, and when each can start.

A plan comes as a sequence. Two steps may run concurrently, or swap, unless one writes what the other
reads or writes, or both need the same device.
"""

from __future__ import annotations

import heapq
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from skiros_py.planning.domain.model import Action, Atom, NoneSuch
from skiros_py.planning.domain.pddl import PddlTexts
from skiros_py.planning.plan import Plan
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.replay import replay
from skiros_py.skills.parameters import Kind
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.view import WorldView

Order = tuple[frozenset[int], ...]
"""For each step the indices of the steps that must have ended before it starts; without transitive ones."""


def order(view: WorldView, task: PlanningTask, texts: PddlTexts, plan: Plan) -> Plan:
    """Returns a plan with its partial order, and with start times if all step durations are known.

    It stays strictly sequential if no other order can be derived.

    The order comes from the PDDL plan. Conditions may depend on more than PDDL models (reasoner results are frozen at
    the start), so the sequence that departs most from the given one is replayed before the order is accepted.

    Args:
        view: The world that the plan starts from.
        task: The planned task.
        texts: The task as PDDL.
        plan: The steps, validated by replay, and their PDDL lines.
    """
    after = partial_order(texts, plan.pddl, task.skills)
    if len(after) != len(plan.steps):
        return plan
    other = tuple(plan.steps[index] for index in contrary(after))
    if other != plan.steps and replay(view, other, task.conditions, task.skills) is not None:
        return plan
    return replace(plan, after=after, starts=_starts(texts, plan, after))


def _starts(texts: PddlTexts, plan: Plan, after: Order) -> tuple[float, ...]:
    actions = [texts.actions[_words(line)[0]] for line in plan.pddl]
    durations = [action.duration for action in actions if action.skill is not None]
    known = [seconds for seconds in durations if seconds is not None]
    return schedule(after, known) if len(known) == len(durations) else ()


def partial_order(texts: PddlTexts, lines: Sequence[str], skills: Mapping[str, SkillDescription]) -> Order:
    """Orders the skills of a PDDL plan; every sequence consistent with it has the same result as the plan.

    Args:
        texts: The task as written.
        lines: The plan, "(drive base_1 robot_1 box_a)" each; bookkeeping actions are skipped.
        skills: The skill descriptions, which state the device parameters.
    """
    actions = _only_changing([_ground(texts, line, skills) for line in lines])
    before: list[int] = []  # for each action those that precede it, as bits
    for index, action in enumerate(actions):
        known = 0
        for earlier in reversed(range(index)):
            if not known >> earlier & 1 and _interfere(actions[earlier], action):
                known |= before[earlier] | 1 << earlier
        before.append(known)
    steps = [index for index, action in enumerate(actions) if action.is_step]
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
class _Ground:
    """One action of the plan: its reads and writes, and the devices it needs."""

    is_step: bool
    reads: frozenset[Atom]
    adds: frozenset[Atom]
    deletes: frozenset[Atom]
    none: tuple[NoneSuch, ...]
    devices: frozenset[str]

    @property
    def writes(self) -> frozenset[Atom]:
        return self.adds | self.deletes


def _ground(texts: PddlTexts, line: str, skills: Mapping[str, SkillDescription]) -> _Ground:
    name, *objects = _words(line)
    action = texts.actions[name]
    ids = (texts.objects.back(object_) for object_ in objects)
    binding = {variable.name: id_ for variable, id_ in zip(action.parameters, ids, strict=True)}
    adds = frozenset(atom.bind(binding) for atom in action.add)
    return _Ground(
        action.skill is not None,
        frozenset(atom.bind(binding) for atom in action.pre),
        adds,
        frozenset(atom.bind(binding) for atom in action.delete) - adds,
        tuple(none.bind(binding) for none in action.none),
        frozenset(_devices(action, binding, skills)),
    )


def _words(line: str) -> list[str]:
    return re.findall(r"[^\s()]+", line)


def _devices(action: Action, binding: Mapping[str, str], skills: Mapping[str, SkillDescription]) -> Iterator[str]:
    if action.skill is not None:
        keys = ("?" + param.key for param in skills[action.skill].params if param.kind is Kind.HARDWARE)
        yield from (binding[key] for key in keys if key in binding)


def _only_changing(actions: Sequence[_Ground]) -> list[_Ground]:
    """Drops facts that are read but never written: they order nothing."""
    changing = frozenset(atom for action in actions for atom in action.writes)
    return [replace(action, reads=action.reads & changing) for action in actions]


def _interfere(one: _Ground, other: _Ground) -> bool:
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


def _touches(action: _Ground, none: Sequence[NoneSuch]) -> bool:
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
    waits = [len(earlier) for earlier in after]
    behind: list[list[int]] = [[] for _ in after]
    for index, earlier in enumerate(after):
        for one in earlier:
            behind[one].append(index)
    ready = [-index for index, number in enumerate(waits) if number == 0]  # as a heap, the last at its front
    heapq.heapify(ready)
    taken: list[int] = []
    while ready:
        taken.append(-heapq.heappop(ready))
        for index in behind[taken[-1]]:
            waits[index] -= 1
            if waits[index] == 0:
                heapq.heappush(ready, -index)
    return tuple(taken)


def schedule(
    after: Order, durations: Sequence[float], needs: Sequence[frozenset[str]] | None = None
) -> tuple[float, ...]:
    """Returns the start time of each step [s] if all start as early as possible.

    >>> schedule((frozenset(), frozenset({0}), frozenset()), [2.0, 1.0, 5.0])
    (0.0, 2.0, 0.0)

    Args:
        after: The order.
        durations: How long each step takes [s].
        needs: The exclusive resources of each step; of two steps that share one, the one with the longer tail goes
            first. Omit it if the order is complete.
    """
    wanted = needs if needs is not None else [frozenset[str]()] * len(after)
    tails = _tails(after, durations)
    starts: dict[int, float] = {}
    free: dict[str, float] = {}
    while len(starts) < len(after):
        ready = [i for i in range(len(after)) if i not in starts and after[i] <= starts.keys()]
        ends = {i: [starts[e] + durations[e] for e in after[i]] + [free.get(n, 0.0) for n in wanted[i]] for i in ready}
        first = min(ready, key=lambda i: (max(ends[i], default=0.0), -tails[i], i))
        starts[first] = max(ends[first], default=0.0)
        free |= dict.fromkeys(wanted[first], starts[first] + durations[first])
    return tuple(starts[i] for i in range(len(after)))


def makespan(starts: Sequence[float], durations: Sequence[float]) -> float:
    """Returns when the last step ends [s]."""
    return max((start + duration for start, duration in zip(starts, durations, strict=True)), default=0.0)


def _tails(after: Order, durations: Sequence[float]) -> list[float]:
    """The minimum time from the start of each step to the end of the plan [s]."""
    tails = list(durations)
    for index in reversed(range(len(after))):
        for earlier in after[index]:
            tails[earlier] = max(tails[earlier], durations[earlier] + tails[index])
    return tails
