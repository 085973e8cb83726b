"""What is still to be done of a plan: which steps wait for which, which run, which have ended."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from skiros_py.planning.plan import Step


class Agenda:
    """The steps of one plan and how far they are. Steps are spoken of by their index.

    Args:
        steps: What is to be done, in an order in which it can be done.
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
        """The steps that run."""
        return tuple(self._running)

    @property
    def done(self) -> bool:
        """True when every step has ended."""
        return not self._waiting and not self._running

    @property
    def ready(self) -> tuple[int, ...]:
        """The steps that nothing has to end before, in order."""
        open_ = self._waiting.keys() | self._running.keys()
        return tuple(index for index in self._waiting if open_.isdisjoint(self._after[index]))

    def start(self, index: int) -> None:
        """Notes that a step runs."""
        del self._waiting[index]
        self._running[index] = None

    def end(self, index: int) -> None:
        """Notes that a step has ended well."""
        del self._running[index]

    def again(self, index: int) -> None:
        """Notes that a step has ended, and is to be done once more."""
        del self._running[index]
        self._waiting = dict.fromkeys(sorted((*self._waiting, index)))

    def rename(self, names: Mapping[str, str]) -> None:
        """Gives what the steps speak of other names."""
        self.steps = [step.renamed(names) for step in self.steps]

    def leads_to(self, earlier: int, later: int) -> bool:
        """Tells whether a step has to wait, by however many others, for another one."""
        open_, seen = [later], set[int]()
        while open_:
            before = self._after[open_.pop()] - seen
            if earlier in before:
                return True
            seen |= before
            open_ += before
        return False

    def with_running(self, running: Sequence[Step], shared: Collection[tuple[int, int]]) -> Agenda:
        """Returns the agenda with steps of another plan that run already before it.

        Args:
            running: These steps; they get the first indices, and run.
            shared: Which of them (first) a step of this agenda (second, by its index here) has to wait for.
        """
        more = len(running)
        after = [{one + more for one in before} for before in self._after]
        for earlier, later in shared:
            after[later].add(earlier)
        joined = Agenda((*running, *self.steps), (*(set[int]() for _ in running), *after))
        for index in range(more):
            joined.start(index)
        return joined
