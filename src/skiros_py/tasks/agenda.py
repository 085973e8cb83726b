"""Progress of a plan: which steps wait for which, which are running, which have ended."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from skiros_py.planning.plan import Step


class Agenda:
    """The steps of one plan and their progress. Steps are identified by index.

    Args:
        steps: The steps, in a feasible order.
        after: For each step the indices of the steps that must have ended before it starts.
    """

    def __init__(self, steps: Sequence[Step], after: Sequence[Collection[int]]) -> None:
        self.steps = list(steps)
        self._after = [set(before) for before in after]
        self._waiting = dict.fromkeys(range(len(self.steps)))
        self._running: dict[int, None] = {}

    @property
    def waiting(self) -> tuple[int, ...]:
        """The steps that have not started, in order."""
        return tuple(self._waiting)

    @property
    def running(self) -> tuple[int, ...]:
        """The running steps."""
        return tuple(self._running)

    @property
    def done(self) -> bool:
        """True when every step has ended."""
        return not self._waiting and not self._running

    @property
    def ready(self) -> tuple[int, ...]:
        """The steps that no unfinished step precedes, in order."""
        open_ = self._waiting.keys() | self._running.keys()
        return tuple(index for index in self._waiting if open_.isdisjoint(self._after[index]))

    def start(self, index: int) -> None:
        """Marks a step as running."""
        del self._waiting[index]
        self._running[index] = None

    def end(self, index: int) -> None:
        """Marks a step as successfully ended."""
        del self._running[index]

    def again(self, index: int) -> None:
        """Marks a step as ended and to be repeated."""
        del self._running[index]
        self._waiting = dict.fromkeys(sorted((*self._waiting, index)))

    def rename(self, names: Mapping[str, str]) -> None:
        """Renames elements in the steps' arguments."""
        self.steps = [step.renamed(names) for step in self.steps]

    def leads_to(self, earlier: int, later: int) -> bool:
        """Returns True if the later step has to wait for the earlier one, directly or transitively."""
        open_, seen = [later], set[int]()
        while open_:
            before = self._after[open_.pop()] - seen
            if earlier in before:
                return True
            seen |= before
            open_ += before
        return False

    def with_running(self, running: Sequence[Step], shared: Collection[tuple[int, int]]) -> Agenda:
        """Returns the agenda preceded by steps of another plan that are already running.

        Args:
            running: These steps; they get the first indices and are marked as running.
            shared: Pairs of a running step and the step of this agenda, by its index here, that has to wait for it.
        """
        more = len(running)
        after = [{one + more for one in before} for before in self._after]
        for earlier, later in shared:
            after[later].add(earlier)
        joined = Agenda((*running, *self.steps), (*(set[int]() for _ in running), *after))
        for index in range(more):
            joined.start(index)
        return joined
