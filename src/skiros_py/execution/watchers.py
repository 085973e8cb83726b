"""What a skill manager runs in the background: primitives that watch the devices of its subsystem."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from skiros_py.execution.cycle import ControlCycle
from skiros_py.execution.modules import Modules
from skiros_py.execution.pulse import Watched
from skiros_py.execution.scope import Scope
from skiros_py.execution.task import Task
from skiros_py.skills.outcome import Outcome
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import HAS_A


class Watchers:
    """The watching primitives of one subsystem: each runs at most once for each device of its class.

    Args:
        modules: What can be run.
        view: Tells the subsystem's devices.
        cycle: Runs them.
        scope: Gives the scope for a run of a name.
    """

    def __init__(self, modules: Modules, view: WorldView, cycle: ControlCycle, scope: Callable[[str], Scope]) -> None:
        self._modules = modules
        self._view = view
        self._cycle = cycle
        self._scope = scope
        self._tasks: dict[str, Task[Outcome]] = {}

    def start(self) -> None:
        """Starts those that do not run, or no longer."""
        self._tasks = {name: task for name, task in self._tasks.items() if not task.done}
        for primitive, device in self._wanted():
            name = f"{primitive} of {device}"
            if name not in self._tasks:
                run = self._modules.run(primitive, {"device": device}, self._scope(name))
                self._tasks[name] = self._cycle.start(run, name=name)

    def stop(self, reason: str) -> None:
        """Ends them all.

        Args:
            reason: Why, for a person.
        """
        for task in self._tasks.values():
            task.stop(reason)
        self._tasks = {}

    def __contains__(self, task: Watched) -> bool:
        return any(own is task for own in tuple(self._tasks.values()))

    def _wanted(self) -> Iterator[tuple[str, str]]:
        for name, primitive in sorted(self._modules.primitives.items()):
            for device in self._view.objects(self._modules.agent, HAS_A) if primitive.watches else ():
                if self._view.ontology.is_a(self._view.element(device).type, primitive.watches or ""):
                    yield name, device
