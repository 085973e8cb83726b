"""Explains why there is no plan: causes, otherwise a conflict, and the minimal changes that make a plan possible."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from contextlib import suppress
from itertools import count
from math import inf

from skiros_py.errors import SkirosError
from skiros_py.messages import Message, listed
from skiros_py.planning.edits import HypotheticalView
from skiros_py.planning.explanation.absent import AbsentSkill, absence_causes
from skiros_py.planning.explanation.causes import find_causes
from skiros_py.planning.explanation.contradictions import cause_of
from skiros_py.planning.explanation.exclusions import exclusive_conditions
from skiros_py.planning.explanation.remedies import Change, Room, advice, remedies
from skiros_py.planning.explanation.wording import Found
from skiros_py.planning.plan import Cause, CauseKind, NoPlan, Repair
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
    search.extend(Change(), found, view)
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
        self._queue: list[tuple[int, int, Change]] = []
        self._order = count()
        self._seen: set[object] = set()
        self._tried = 0

    def extend(self, change: Change, found: Sequence[Found], view: WorldView) -> None:
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

    def _is_new(self, change: Change) -> bool:
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
        with suppress(SkirosError):  # a change that cannot be applied, or breaks the goal, is no repair
            self._look_at(change)
        return True

    def _look_at(self, change: Change) -> None:
        view, goal = self._after(change)
        left = find_causes(build_task(view, self._capabilities, goal))
        if left:
            self.extend(change, left, view)
            return
        self._tried += 1
        if self._solve(view, goal):
            smallest = self._reduced(change)
            if not any(smallest.includes(offer) for offer in self.offers):
                self.offers.append(smallest.repair())

    def _after(self, change: Change) -> tuple[WorldView, list[Condition]]:
        """Returns the world and the goal after a change."""
        view = HypotheticalView(self._view)
        for edit in change.edits:
            edit.write(view)
        return view, change.wanted(self._goal)

    def _reduced(self, change: Change) -> Change:
        """Reduces a working change to a minimal one."""
        for smaller in change.leaving_out():
            if not smaller.is_nothing and self._works(smaller):
                return self._reduced(smaller)
        return change

    def _works(self, change: Change) -> bool:
        view, goal = self._after(change)
        if find_causes(build_task(view, self._capabilities, goal)):
            return False
        return bool(self._solve(view, goal))


Reachable = Callable[[Sequence[Condition]], bool | None]
"""Returns whether conditions can be reached together, None if that is not known."""

_MOST_CALLS = 16
"""Maximum number of planner calls per explanation."""


def explain(task: PlanningTask, solve: Solve | None = None, absent: Sequence[AbsentSkill] = ()) -> NoPlan:
    """Explains why a task has no plan.

    Args:
        task: The complete task: anything left out of it is not explained.
        solve: Tries changed worlds and goals; if omitted, no conflict is narrowed down and no repair is offered.
        absent: Skills that are installed but cannot be used.
    """
    found = find_causes(task)
    if not found:
        goal = exclusive_conditions(task)
        if not goal:
            goal = task.conditions
            if solve is not None and len(goal) > 1:
                goal = smallest_unsolvable(goal, lambda some: solve(task.view, some))
        found = (Found(conflict_of(goal)),)
    left_out = dict.fromkeys(absence_causes(found, absent, task.view.ontology))
    causes = (*(one.cause for one in found), *left_out)
    repairs = () if solve is None else find_repairs(found, task.view, task.conditions, task.capabilities, solve)
    return NoPlan(tuple(dict.fromkeys(cause.text for cause in causes)), causes, repairs)


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
    arguments = tuple(dict.fromkeys(argument for condition in conditions for argument in condition.arguments))
    if len(conditions) == 1:
        why = Message("whatever is done for it undoes something else that it needs")
        return cause_of(conditions, why, arguments, CauseKind.CONFLICT)
    said = listed(map(str, conditions))
    text = Message("{conditions} could each be reached, but not all of them together", conditions=said)
    return Cause(CauseKind.CONFLICT, text, tuple(conditions), elements=arguments)
