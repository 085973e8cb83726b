"""Assigns the chains of a plan to robots, and puts them in the order that ends soonest (job-shop scheduling).

A chain is what has to be done to one thing: fetch it, bring it. It consists of legs: a robot drives somewhere and does
something there. Dispatching (the robot that is free first takes the chain whose first leg ends soonest) gives a
schedule at once; local search over the chains of each robot (move one, swap two) improves it, with a fixed number of
tries, so that the result does not depend on the clock.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import ceil, inf
from typing import Any

from skiros_py.planning.domain.actions import passed_keys
from skiros_py.planning.domain.matching import FactIndex, solutions
from skiros_py.planning.domain.model import Atom
from skiros_py.planning.plan import Step
from skiros_py.planning.plan_validation import TaskState
from skiros_py.planning.problem.reachability import USUAL
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.robots.allocation import moved_by
from skiros_py.planning.robots.docking import Docking
from skiros_py.planning.robots.ordering import Effect
from skiros_py.world.vocabulary import ROBOT

_SAME = 1e-6
"""Times that differ by less count as equal [s]."""
_ASIDES = 3
"""How often robots may be moved out of the way, for each leg of a schedule."""


@dataclass(frozen=True, slots=True, eq=False)
class Operation:
    """A step in a schedule.

    Attributes:
        step: The step.
        robot: Who does it.
        place: Where it moves the robot; empty if it does not.
        effects: The effects of its actions that were applied so far, with their durations [s].
    """

    step: Step
    robot: str
    place: str = ""
    effects: list[tuple[Effect, float]] = field(default_factory=list)


Leg = tuple[Operation, ...]
"""The steps of one robot up to the next one that does something to a thing."""


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """One way to do a chain.

    Attributes:
        chain: The number of the chain.
        robot: Who does it.
        legs: Its steps.
        things: What it is done to.
    """

    chain: int
    robot: str
    legs: tuple[Leg, ...]
    things: frozenset[str]

    @property
    def places(self) -> tuple[str, ...]:
        """Where the robot goes."""
        return tuple(place for leg in self.legs for place in _places(leg))


def _places(leg: Leg) -> list[str]:
    return [operation.place for operation in leg if operation.place]


class Schedule:
    """Steps one after the other, and when they end if each starts as early as possible.

    Attributes:
        steps: The steps.
        ends: When each robot has done its steps [s].
        at: Where each robot is then.
    """

    def __init__(self, task: PlanningTask) -> None:
        self.steps: tuple[Step, ...] = ()
        self.ends = dict.fromkeys(task.teams, 0.0)
        placed = ((robot, task.view.placement(robot)) for robot in task.teams if task.view.has(robot))
        self.at = {robot: placement.place for robot, placement in placed if placement is not None}
        self._skills = task.skills
        self._state = TaskState(task)
        self._added: dict[Atom, float] = {}
        self._deleted: dict[Atom, float] = {}
        self._read: dict[Atom, float] = {}
        self._used: dict[str, float] = {}

    @property
    def makespan(self) -> float:
        """When the last step ends [s]."""
        return max(self.ends.values(), default=0.0)

    def extended(self, leg: Leg) -> Schedule | None:
        """Returns the schedule with a further leg; None if a step is not possible then."""
        other = copy(self)
        copies = {name: value.copy() for name, value in vars(self).items() if name not in ("steps", "_skills")}
        vars(other).update(copies)
        return other if all(map(other.take, leg)) else None

    def take(self, operation: Operation) -> bool:
        """Adds a step, if it is not needless; returns False, and changes nothing, if it is not possible."""
        found = next((e for e in operation.effects if self._state.holds(e[0].reads)), None)
        if found is None:
            taken = self._state.possible(operation.step)
            if taken is None:
                return False
            effect = Effect.of(taken, self._skills)
            known = taken.action.seconds(taken.binding)
            seconds = USUAL if known is None else known
            found = replace(effect, reads=self._state.changing(effect.reads)), seconds
            if not effect.none:
                operation.effects.append(found)
        if self._state.holds(found[0].adds) and not any(self._state.holds([atom]) for atom in found[0].deletes):
            return True  # such as a drive to where the robot is
        self._state.apply(found[0].deletes, found[0].adds)
        end = self._start(found[0]) + found[1]
        self._note(found[0], end)
        robot = operation.robot
        self.ends[robot] = max(self.ends[robot], end)
        self.at[robot] = operation.place or self.at.get(robot, "")
        self.steps = (*self.steps, operation.step)
        return True

    def _start(self, effect: Effect) -> float:
        """Returns when an action can start [s]: after the earlier ones that it must not be swapped with."""
        added, deleted, read = self._added, self._deleted, self._read
        before: list[tuple[Mapping[Any, float], Iterable[object]]] = [
            (added, effect.reads), (deleted, effect.reads), (deleted, effect.adds), (read, effect.adds),
            (added, effect.deletes), (read, effect.deletes), (self._used, effect.devices),
        ]  # fmt: skip
        return max((times[key] for times, keys in before for key in keys if key in times), default=0.0)

    def _note(self, effect: Effect, end: float) -> None:
        after: list[tuple[dict[Any, float], Iterable[object]]] = [
            (self._added, effect.adds), (self._deleted, effect.deletes), (self._read, effect.reads),
            (self._used, effect.devices),
        ]  # fmt: skip
        for times, keys in after:
            for key in keys:
                times[key] = max(times.get(key, 0.0), end)


def makespan(task: PlanningTask, steps: Iterable[Step]) -> float:
    """Returns how long steps take if each starts as early as possible [s]; infinite if they are not possible."""
    docking, found = Docking(task), Schedule(task)
    possible = all(found.take(Operation(step, docking.robot(step))) for step in steps)
    return found.makespan if possible else inf


Assignment = dict[str, list[Way]]
"""What each robot does, in order."""


class Scheduler:
    """Schedules chains.

    Args:
        task: The task.
        chains: The ways to do each chain, one of which is taken.
        seed: Of the random choices.
    """

    def __init__(self, task: PlanningTask, chains: Sequence[Sequence[Way]], seed: int = 0) -> None:
        self._task = task
        self._chains = chains
        self._empty = Schedule(task)
        self._docking = Docking(task)
        self._moves = {robot: tuple(_moves(task, robot)) for robot in task.teams}
        self._seed = seed
        self._random = random.Random(seed)  # noqa: S311

    def best(self, tries: int) -> Schedule | None:
        """Returns the best schedule found; None if there is none.

        Robots may be in each other's way: if not all are of use, half of them are tried, a quarter, and so on.

        Args:
            tries: How often the first schedule for so many robots is changed in order to improve it.
        """
        found = self._searched(tries)
        robots = list(dict.fromkeys(way.robot for chain in self._chains for way in chain))
        some = robots[: len(robots) // 2]
        fewer = [[way for way in chain if way.robot in some] for chain in self._chains]
        if (found is not None and found.makespan <= self._bound + _SAME) or not all(fewer):
            return found
        other = Scheduler(self._task, fewer, self._seed).best(tries)
        return min((one for one in (found, other) if one is not None), key=_score, default=None)

    def _searched(self, tries: int) -> Schedule | None:
        """Returns the best schedule found in which every robot may do something."""
        best = self._run({r: [w for chain in self._chains for w in chain if w.robot == r] for r in self._moves}, False)
        for _ in range(tries if best else 0):
            if best is None or best.now.makespan <= self._bound + _SAME:
                break
            changed = self._changed(best.done, best.now)
            other = self._run(changed, True) if changed else None
            if other is not None and _score(other.now) <= _score(best.now):
                best = other
        return best.now if best else None

    def _run(self, ways: Assignment, in_order: bool) -> _Run | None:
        run = _Run(self._empty, ways, in_order, self._moves, self._docking)
        return run if run.complete() else None

    @cached_property
    def _bound(self) -> float:
        """What hardly any schedule is shorter than [s]: one robot has its share, and one place takes one at a time."""
        lasts = {a.skill: USUAL if a.duration is None else a.duration for a in self._task.domain.actions}

        def seconds(legs: Iterable[Leg]) -> float:
            return sum(lasts[operation.step.skill] for leg in legs for operation in leg)

        shortest = sorted(min(seconds(way.legs) for way in chain) for chain in self._chains)
        robots = {way.robot for chain in self._chains for way in chain}
        bound = max(*shortest, sum(shortest[: ceil(len(shortest) / len(robots))]))
        leaving = min((lasts[move.step.skill] for moves in self._moves.values() for move in moves), default=0.0)
        visits: dict[str, list[tuple[float, float]]] = {}
        for first, *others in self._chains:
            for number, leg in enumerate(first.legs):
                for place in _places(leg):
                    if all(place in way.places for way in others):
                        visits.setdefault(place, []).append((seconds([leg]), seconds(first.legs[:number])))
        for visit in visits.values():
            busy = sum(stay for stay, _ in visit) + leaving * (len(visit) - 1) + min(before for _, before in visit)
            bound = max(bound, busy)
        return bound

    def _changed(self, ways: Assignment, schedule: Schedule) -> Assignment | None:
        """Returns an assignment with one chain moved, or two swapped; None if the choice allows neither."""
        busy = [robot for robot, own in ways.items() if own]
        last = [robot for robot in busy if schedule.ends[robot] >= schedule.makespan - _SAME]
        robot = self._random.choice(last if last and self._random.random() < 0.7 else busy)
        chosen = self._random.choice(ways[robot])
        ends = {way: schedule.ends[way.robot] for way in self._chains[chosen.chain]}
        soonest = [way for way, end in ends.items() if end == min(ends.values())]
        other = self._random.choice(soonest if self._random.random() < 0.5 else self._chains[chosen.chain])
        changed = {r: [way for way in own if way is not chosen] for r, own in ways.items()}
        target = changed[other.robot]
        if target and self._random.random() < 0.5:
            swapped = self._random.choice(target)
            back = next((way for way in self._chains[swapped.chain] if way.robot == robot), None)
            if back is None:
                return None
            target[target.index(swapped)] = other
            changed[robot].insert(min(ways[robot].index(chosen), len(changed[robot])), back)
        else:
            target.insert(self._random.randint(0, len(target)), other)
        return changed


class _Run:
    """Schedules leg by leg; the robot that is free first goes on.

    Args:
        empty: The schedule without steps.
        ways: What each robot does, or may do.
        in_order: True if it does all of it, in this order; False if it takes what suits best.
        moves: Steps that only move a robot.
        docking: Tells distances.

    Attributes:
        now: The schedule so far.
        done: What each robot does, in order.
    """

    def __init__(
        self,
        empty: Schedule,
        ways: Assignment,
        in_order: bool,
        moves: Mapping[str, tuple[Operation, ...]],
        docking: Docking,
    ) -> None:
        self.now = empty
        self.done: Assignment = {robot: [] for robot in ways}
        self._left = {robot: list(own) for robot, own in ways.items()}
        self._begun: dict[str, tuple[Leg, ...]] = dict.fromkeys(ways, ())
        self._in_order = in_order
        self._moves = moves
        self._docking = docking

    def complete(self) -> bool:
        """Schedules everything; returns False if the robots block each other for ever."""
        asides = _ASIDES * sum(len(way.legs) for own in self._left.values() for way in own)
        while any(self._begun.values()) or any(self._left.values()):
            if not self._go_on():
                asides -= 1
                if asides < 0 or not self._make_way():
                    return False
        return True

    def _go_on(self) -> bool:
        """Schedules the next leg; returns whether any is possible."""
        waiting = (robot for robot in self._left if self._begun[robot] or self._left[robot])
        for robot in sorted(waiting, key=lambda robot: (self.now.ends[robot], robot)):
            if self._begun[robot]:
                then = self.now.extended(self._begun[robot][0])
                if then is not None:
                    self.now, self._begun[robot] = then, self._begun[robot][1:]
                    return True
            elif (chosen := self._chosen(robot)) is not None:
                way, self.now = chosen
                self._begun[robot] = way.legs[1:]
                self.done[robot].append(way)
                self._left = {r: [w for w in own if w.chain != way.chain] for r, own in self._left.items()}
                return True
        return False

    def _chosen(self, robot: str) -> tuple[Way, Schedule] | None:
        """Returns what a robot begins next: what ends soonest, at places in little demand, where it was before."""
        ways = self._left[robot][:1] if self._in_order else self._left[robot]
        tried = [(way, then) for way in ways if (then := self.now.extended(way.legs[0])) is not None]
        if len(tried) < 2:
            return tried[0] if tried else None
        taken = Counter(place for own in self.done.values() for way in own for place in way.places)
        visited = {place for way in self.done[robot] for place in way.places}
        later = Counter(place for own in self._left.values() for way in own for place in way.places)

        def urgency(one: tuple[Way, Schedule]) -> tuple[float, ...]:
            way, then = one
            crowd = max((taken[place] for place in way.places), default=0)
            demand = max((later[place] for place in way.places), default=0)
            driven = self._docking.distance(robot, way.places, self.now.at.get(robot) if self.done[robot] else None)
            return round(then.ends[robot], 6), crowd, -demand, len({*way.places} - visited), driven

        return min(tried, key=urgency)

    def _make_way(self) -> bool:
        """Moves a robot away from where another one has to go; returns whether that one can go on then."""
        begun = ((self._begun[robot], own) for robot, own in self._left.items() if self._begun[robot] or own)
        legs = [rest[0] if rest else own[0].legs[0] for rest, own in begun]
        wanted = {place for leg in legs for place in _places(leg)[:1]}
        later = {place for own in self._left.values() for way in own for place in way.places} | wanted
        blocking = [robot for robot, place in self.now.at.items() if place in wanted]
        for robot in sorted(blocking, key=lambda r: (bool(self._begun[r] or self._left[r]), self.now.ends[r], r)):
            before = self.now
            found = self._elsewhere(robot, later)
            if found is not None:
                self.now = found
                if any(found.extended(leg) for leg in legs if leg[0].robot != robot) and self._go_on():
                    return True
            self.now = before
        return False

    def _elsewhere(self, robot: str, wanted: Collection[str]) -> Schedule | None:
        """Returns the schedule in which a robot leaves for the place that is free first, best an unwanted one."""
        best, soonest = None, inf
        for move in sorted(self._moves[robot], key=lambda move: move.place in wanted):
            then = self.now.extended((move,)) if move.place != self.now.at.get(robot) else None
            if then is not None and then.ends[robot] < soonest - _SAME:
                best, soonest = then, then.ends[robot]
                if move.effects and soonest <= self.now.ends[robot] + move.effects[0][1] + _SAME:
                    break  # without waiting
        return best


def _score(schedule: Schedule) -> tuple[float, float]:
    return round(schedule.makespan, 6), round(sum(schedule.ends.values()), 6)


def _moves(task: PlanningTask, robot: str) -> Iterator[Operation]:
    """Yields the steps that move a robot somewhere, and do nothing else."""
    ontology = task.view.ontology
    changing = {atom.predicate for action in task.domain.actions for atom in (*action.add, *action.delete)}
    fixed = FactIndex(atom for atom in sorted(task.problem.init) if atom.predicate not in changing)
    for action in task.domain.actions:
        moved = moved_by(action, ontology)
        if action.skill is None or len(moved) != 1 or not ontology.is_a(action.types[moved[0][0]] or "", ROBOT):
            continue
        lasting = [atom for atom in action.pre if atom.predicate not in changing]
        keys = passed_keys(task.skills[action.skill])
        for found in solutions(lasting, fixed, {moved[0][0]: robot}, action.types, task.fits):
            if all(f"?{key}" in found for key in keys) and moved[0][1] in found:
                step = Step(action.skill, {key: found[f"?{key}"] for key in keys})
                yield Operation(step, robot, found[moved[0][1]])
