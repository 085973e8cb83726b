"""When each condition of a goal came to be believed."""

from __future__ import annotations

import time
from collections.abc import Sequence

from skiros_py.execution.cycle import ControlCycle
from skiros_py.planning.problem.stock import believed
from skiros_py.skills.conditions import Condition
from skiros_py.world.world import World


class Moments:
    """Notes when each condition of a goal came to be believed for good.

    Args:
        world: The live world model.
        goal: The conditions.
        cycle: Gives the time.
    """

    def __init__(self, world: World, goal: Sequence[Condition], cycle: ControlCycle) -> None:
        self._world = world
        self._goal = goal
        self._cycle = cycle
        self._start = cycle.board.snapshot.time, time.perf_counter()
        self._since: dict[Condition, tuple[float, float]] = {}
        self._version = -1
        self.note()

    @property
    def used(self) -> tuple[float, float]:
        """Simulated and wall time since the start [s]."""
        return self._cycle.board.snapshot.time - self._start[0], time.perf_counter() - self._start[1]

    def held(self, condition: Condition) -> bool:
        """Tells whether a condition was believed when the world was last looked at."""
        return condition in self._since

    def since(self, condition: Condition) -> tuple[float | None, float | None]:
        """Returns simulated and wall time at which a condition that is believed came to be so [s]."""
        self.note()
        return self._since.get(condition, (None, None))

    def note(self) -> None:
        """Looks at the conditions, if the world has changed."""
        if self._version == self._world.version:
            return
        self._version = self._world.version
        for condition in self._goal:
            if not believed(condition, self._world):
                self._since.pop(condition, None)
            elif condition not in self._since:
                self._since[condition] = self.used
