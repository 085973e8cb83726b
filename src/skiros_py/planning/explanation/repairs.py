"""The smallest changes after which there is a plan: a search over remedies, each result tried before it is offered."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from itertools import count

from skiros_py.errors import SkirosError
from skiros_py.planning.explanation.causes import Found, find_causes
from skiros_py.planning.explanation.edits import Add, SceneEdit
from skiros_py.planning.explanation.remedies import Remedy, advice, remedies
from skiros_py.planning.explanation.supposition import Supposition
from skiros_py.planning.explanation.wording import listed
from skiros_py.planning.problem.task import Capability, build_task
from skiros_py.planning.reasons import Repair
from skiros_py.skills.conditions import Condition
from skiros_py.world.view import WorldView

__all__ = ["Solve", "find_repairs"]

Solve = Callable[[WorldView, Sequence[Condition]], bool | None]
"""Tells whether a goal has a plan that survives its replay; None when nobody knows."""

_OFFERED = 5
_LOOKED_AT = 32
"""How many combinations of changes are looked at."""
_TRIED = 12
"""How many of them are planned for."""


@dataclass(frozen=True, slots=True)
class _Change:
    """Some remedies taken together.

    Attributes:
        cost: How much of a change that is.
        edits: What they change in the scene.
        without: Conditions given up.
    """

    cost: int = 0
    edits: tuple[SceneEdit, ...] = ()
    without: tuple[Condition, ...] = ()

    def and_(self, remedy: Remedy) -> _Change | None:
        """Returns the change with one more remedy; None where that is nothing new."""
        edits = tuple(e for e in remedy.edits if isinstance(e, Add) or e not in self.edits)
        without = tuple(c for c in remedy.without if c not in self.without)
        if not edits and not without:
            return None
        return _Change(self.cost + remedy.cost, self.edits + edits, self.without + without)

    @property
    def key(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The same for changes that come to the same."""
        return tuple(sorted(map(str, self.edits))), tuple(sorted(map(str, self.without)))

    def includes(self, offer: Repair) -> bool:
        """Tells whether it does all that an offer does."""
        return set(offer.edits) <= set(self.edits) and set(offer.without) <= set(self.without)

    def repair(self) -> Repair:
        """Returns it as an offer."""
        given_up = [f"give up {listed(map(str, self.without))}"] if self.without else []
        text = " and ".join([*map(str, dict.fromkeys(self.edits)), *given_up])
        return Repair(text, self.edits, self.without)


def find_repairs(
    found: Sequence[Found],
    view: WorldView,
    goal: Sequence[Condition],
    capabilities: Sequence[Capability],
    solve: Solve,
) -> Generator[None, None, tuple[Repair, ...]]:
    """Finds changes after which there is a plan, smallest first; yields after each that was looked at.

    Causes are taken one by one: what is done about the first may show another one behind it. A planner is asked only
    where no cause is left.

    Args:
        found: The causes.
        view: The world; it is not changed.
        goal: The goal.
        capabilities: The skills that are there.
        solve: Tries a changed world or goal.
    """
    search = _Search(view, goal, capabilities, solve)
    search.extend(_Change(), found, view)
    for _ in range(_LOOKED_AT):
        if not search.step():
            break
        yield
    outside = [Repair(text) for text in dict.fromkeys(advice(one.cause) for one in found) if text]
    needed = outside if not any(repair.edits for repair in search.offers) else []
    return (*needed, *search.offers)[:_OFFERED]


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
        self._queue: list[tuple[int, int, _Change]] = []
        self._order = count()
        self._seen: set[object] = set()
        self._tried = 0

    def extend(self, change: _Change, found: Sequence[Found], view: WorldView) -> None:
        """Puts everything that could be done about the first of the causes that are left into the queue."""
        for remedy in remedies(found[0], view):
            further = change.and_(remedy)
            if further is not None and self._is_new(further):
                self._seen.add(further.key)
                left = further.cost + len(found) - 1
                heapq.heappush(self._queue, (left, next(self._order), further))

    def _is_new(self, change: _Change) -> bool:
        """Tells whether a change is worth a look: not seen, not more than one that is offered, and a goal is left."""
        more = any(change.includes(offer) for offer in self.offers)
        return not more and change.key not in self._seen and len(change.without) < len(self._goal)

    def step(self) -> bool:
        """Looks at the most promising change; returns False where there is nothing left to do."""
        if not self._queue or len(self.offers) == _OFFERED or self._tried == _TRIED:
            return False
        _, _, change = heapq.heappop(self._queue)
        if any(change.includes(offer) for offer in self.offers):
            return True
        try:
            self._look_at(change)
        except SkirosError:  # a change that cannot be made, or after which the goal cannot be said, is no repair
            return True
        return True

    def _look_at(self, change: _Change) -> None:
        view = Supposition(self._view)
        for edit in change.edits:
            edit.suppose(view)
        goal = [condition for condition in self._goal if condition not in change.without]
        left = find_causes(build_task(view, self._capabilities, goal), view)
        if left:
            self.extend(change, left, view)
            return
        self._tried += 1
        if self._solve(view, goal):
            self.offers.append(change.repair())
