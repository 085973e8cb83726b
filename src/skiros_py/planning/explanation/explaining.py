"""Explains why there is no plan: causes, otherwise a conflict, and the minimal changes that make a plan possible."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count
from math import inf

from skiros_py.errors import SkirosError
from skiros_py.planning.explanation.causes import find_causes
from skiros_py.planning.explanation.edits import Add, HypotheticalView, Move, Remove, SceneEdit
from skiros_py.planning.explanation.facts import exclusive_conditions
from skiros_py.planning.explanation.remedies import Remedy, Room, advice, remedies
from skiros_py.planning.explanation.wording import Found, listed
from skiros_py.planning.plan import Cause, CauseKind, Exchange, Repair
from skiros_py.planning.problem.task import Capability, PlanningTask, build_task
from skiros_py.skills.conditions import Condition
from skiros_py.world.view import WorldView

Solve = Callable[[WorldView, Sequence[Condition]], bool | None]
"""Returns whether a goal has a plan that survives its replay, None if that is not known."""

_OFFERED = 5
_LOOKED_AT = 32
"""How many combinations of changes are examined."""
_TRIED = 12
"""For how many of them a planner is run."""


@dataclass(frozen=True, slots=True)
class _Change:
    """A combination of remedies.

    Attributes:
        cost: The size of the change.
        edits: Their changes to the scene.
        without: Conditions given up.
        instead: Conditions replaced.
    """

    cost: int = 0
    edits: tuple[SceneEdit, ...] = ()
    without: tuple[Condition, ...] = ()
    instead: tuple[Exchange, ...] = ()

    def and_(self, remedy: Remedy) -> _Change | None:
        """Returns the change with one more remedy.

        None if it adds nothing new, moves a thing again, or changes an already replaced condition.
        """
        edits = tuple(e for e in remedy.edits if isinstance(e, Add) or e not in self.edits)
        without = tuple(c for c in remedy.without if c not in self.without)
        if not (edits or without or remedy.instead) or _placed(edits) & _placed(self.edits):
            return None
        if {exchange.by for exchange in self.instead}.intersection(without, (e.condition for e in remedy.instead)):
            return None
        both = self.edits + edits, self.without + without, self.instead + remedy.instead
        return _Change(self.cost + remedy.cost, *both)

    def wanted(self, goal: Sequence[Condition]) -> list[Condition]:
        """Returns the goal after the change."""
        by = {exchange.condition: exchange.by for exchange in self.instead}
        return [by.get(condition, condition) for condition in goal if condition not in self.without]

    def leaving_out(self) -> Iterator[_Change]:
        """Yields the changes with one remedy less."""
        for i in range(len(self.edits)):
            yield replace(self, edits=self.edits[:i] + self.edits[i + 1 :])
        for condition in self.without:
            yield replace(self, without=tuple(c for c in self.without if c is not condition))
        for exchange in self.instead:
            yield replace(self, instead=tuple(e for e in self.instead if e is not exchange))

    @property
    def key(self) -> tuple[tuple[str, ...], ...]:
        """A key that is equal for equivalent changes."""
        return tuple(tuple(sorted(map(str, each))) for each in (self.edits, self.without, self.instead))

    @property
    def is_nothing(self) -> bool:
        """Whether it changes nothing."""
        return not (self.edits or self.without or self.instead)

    def includes(self, offer: Repair) -> bool:
        """Returns whether it does everything an offer does; alternative places are considered equivalent."""
        otherwise = {exchange.condition for exchange in offer.instead}
        also = otherwise <= {exchange.condition for exchange in self.instead}
        return also and set(offer.edits) <= set(self.edits) and set(offer.without) <= set(self.without)

    def repair(self) -> Repair:
        """Returns it as a repair to be offered."""
        given_up = [f"give up {listed(map(str, self.without))}"] if self.without else []
        text = " and ".join([*map(str, self.instead), *map(str, dict.fromkeys(self.edits)), *given_up])
        return Repair(text, self.edits, self.without, self.instead)


def _placed(edits: Sequence[SceneEdit]) -> set[str]:
    """Returns the elements that are placed or removed."""
    return {edit.element for edit in edits if isinstance(edit, Move | Remove)}


def find_repairs(
    found: Sequence[Found],
    view: WorldView,
    goal: Sequence[Condition],
    capabilities: Sequence[Capability],
    solve: Solve,
) -> tuple[Repair, ...]:
    """Finds changes that make a plan possible, smallest first.

    Causes are handled one by one: fixing the first may reveal another one. A planner is run only if no cause is left.

    Args:
        found: The causes.
        view: The world; it is not changed.
        goal: The goal.
        capabilities: The available skills.
        solve: Tries a changed world or goal.
    """
    search = _Search(view, goal, capabilities, solve)
    search.extend(_Change(), found, view)
    for _ in range(_LOOKED_AT):
        if not search.step():
            break
    offers = _simplest(search.offers)
    needed = _outside(found) if not any(repair.edits for repair in offers) else []
    return (*needed, *offers)[:_OFFERED]


def _outside(found: Sequence[Found]) -> list[Repair]:
    """Returns what the user has to arrange; nothing if conditions exclude each other, since that would remain."""
    causes = [one.cause for one in found]
    if any(cause.kind is CauseKind.CONTRADICTION for cause in causes):
        return []
    return [Repair(text) for text in dict.fromkeys(map(advice, causes)) if text]


def _simplest(offers: Sequence[Repair]) -> list[Repair]:
    """Removes offers that change more than needed, or both scene and goal if one of them is enough.

    Giving up more conditions never counts as enough: changes to both that keep a condition are milder.
    """
    fewest = min((_size(offer) for offer in offers), default=0)
    short = [offer for offer in offers if _size(offer) <= fewest + 1]
    given_up = min((len(offer.without) for offer in short if _kinds(offer) < 2), default=inf)
    return [offer for offer in short if _kinds(offer) < 2 or len(offer.without) < given_up]


def _kinds(offer: Repair) -> int:
    return sum(map(bool, (offer.edits, offer.without, offer.instead)))


def _size(offer: Repair) -> int:
    return len(offer.edits) + len(offer.without) + len(offer.instead)


class _Search:
    """Best first: changes by their cost and by how many causes are left."""

    def __init__(
        self, view: WorldView, goal: Sequence[Condition], capabilities: Sequence[Capability], solve: Solve
    ) -> None:
        self.offers: list[Repair] = []
        self._view = view
        self._goal = goal
        self._capabilities = capabilities
        self._solve = solve
        self._room = Room(capabilities, view.ontology)
        self._queue: list[tuple[int, int, _Change]] = []
        self._order = count()
        self._seen: set[object] = set()
        self._tried = 0

    def extend(self, change: _Change, found: Sequence[Found], view: WorldView) -> None:
        """Queues every possible remedy for the first of the remaining causes."""
        made = set(view.further) if isinstance(view, HypotheticalView) else set[str]()
        for remedy in remedies(found[0], change.wanted(self._goal), view, self._room):
            if made.intersection(name for edit in remedy.edits for name in edit.elements):
                continue  # elements added by the change have no name yet
            further = change.and_(remedy)
            if further is not None and self._is_new(further):
                self._seen.add(further.key)
                left = further.cost + len(found) - 1
                heapq.heappush(self._queue, (left, next(self._order), further))

    def _is_new(self, change: _Change) -> bool:
        """Returns whether a change is worth examining: new, not larger than an offered one, and leaving a goal."""
        more = any(change.includes(offer) for offer in self.offers)
        return not more and change.key not in self._seen and len(change.without) < len(self._goal)

    def step(self) -> bool:
        """Examines the most promising change; returns False if there is nothing left to do."""
        if not self._queue or len(_simplest(self.offers)) == _OFFERED or self._tried == _TRIED:
            return False
        _, _, change = heapq.heappop(self._queue)
        if any(change.includes(offer) for offer in self.offers):
            return True
        try:
            self._look_at(change)
        except SkirosError:  # a change that cannot be applied, or breaks the goal, is no repair
            return True
        return True

    def _look_at(self, change: _Change) -> None:
        view, goal = self._after(change)
        left = find_causes(build_task(view, self._capabilities, goal), view)
        if left:
            self.extend(change, left, view)
            return
        self._tried += 1
        if self._solve(view, goal):
            smallest = self._reduced(change)
            if not any(smallest.includes(offer) for offer in self.offers):
                self.offers.append(smallest.repair())

    def _after(self, change: _Change) -> tuple[WorldView, list[Condition]]:
        """Returns the world and the goal after a change."""
        view = HypotheticalView(self._view)
        for edit in change.edits:
            edit.suppose(view)
        return view, change.wanted(self._goal)

    def _reduced(self, change: _Change) -> _Change:
        """Reduces a working change to a minimal one."""
        for smaller in change.leaving_out():
            if not smaller.is_nothing and self._works(smaller):
                return self._reduced(smaller)
        return change

    def _works(self, change: _Change) -> bool:
        view, goal = self._after(change)
        if find_causes(build_task(view, self._capabilities, goal), view):
            return False
        return bool(self._solve(view, goal))


Reachable = Callable[[Sequence[Condition]], bool | None]
"""Returns whether conditions can be reached together, None if that is not known."""

_MOST_CALLS = 16
"""Maximum number of planner calls per explanation."""


@dataclass(frozen=True, slots=True)
class Explanation:
    """Why there is no plan, and what would help.

    Attributes:
        causes: Why; empty if nothing was found.
        repairs: Minimal changes that make a plan possible, smallest first.
    """

    causes: tuple[Cause, ...]
    repairs: tuple[Repair, ...] = ()

    @property
    def reasons(self) -> tuple[str, ...]:
        """The causes in the operator's words."""
        return tuple(cause.text for cause in self.causes)


def explain(task: PlanningTask, view: WorldView, solve: Solve | None = None) -> Explanation:
    """Explains why a task has no plan.

    Args:
        task: The complete task: anything left out of it is not explained.
        view: The world it was made from.
        solve: Tries changed worlds and goals; if omitted, no conflict is narrowed down and no repair is offered.
    """
    found = find_causes(task, view)
    if not found:
        goal = exclusive_conditions(task, view.ontology)
        found = (Found(conflict_of(goal)),) if goal else ()
    if not found:
        goal = task.conditions
        if solve is not None and len(goal) > 1:
            goal = smallest_unsolvable(goal, lambda some: solve(view, some))
        found = (Found(conflict_of(goal)),)
    causes = tuple(one.cause for one in found)
    if solve is None:
        return Explanation(causes)
    return Explanation(causes, find_repairs(found, view, task.conditions, task.capabilities, solve))


def smallest_unsolvable(goal: Sequence[Condition], reachable: Reachable) -> tuple[Condition, ...]:
    """Removes conditions as long as the rest remains unreachable: returns a minimal unsolvable subset.

    Only proven unsolvability counts: if the planner cannot tell, the condition stays. In a goal with more conditions
    than planner calls, the last ones stay.
    """
    kept = list(goal)
    for condition in goal[:_MOST_CALLS]:
        rest = [other for other in kept if other is not condition]
        if rest and reachable(rest) is False:
            kept = rest
    return tuple(kept)


def conflict_of(conditions: Sequence[Condition]) -> Cause:
    """Returns the cause that conditions are unreachable together although each is reachable alone."""
    if len(conditions) > 1:
        why, text = "", f"{listed(map(str, conditions))} could each be reached, but not all of them together"
    else:
        why = "whatever is done for it undoes something else that it needs"
        text = f"{conditions[0]} cannot be reached: {why}"
    arguments = dict.fromkeys(argument for condition in conditions for argument in condition.arguments)
    return Cause(CauseKind.CONFLICT, text, tuple(conditions), elements=tuple(arguments), why=why)
