"""Primitives are loaded once per skill manager, when they are first wanted (paper §3.2)."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from skiros_py.errors import ModuleError
from skiros_py.execution.configuration import configuration_of
from skiros_py.execution.contained import contained, words
from skiros_py.execution.pulse import Chore, CycleOverrun, Pulse
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import BROKEN, Failure
from skiros_py.skills.primitive import Primitive

_log = logging.getLogger(__name__)

_LIMIT = 30.0
"""Wall time for which loading one primitive may hold the control thread [s]."""


@dataclass(frozen=True, slots=True)
class Loaded:
    """A primitive that a skill manager has loaded.

    Attributes:
        cls: Its class.
        config: Values of its configuration parameters.
        resource: What its :meth:`~skiros_py.skills.primitive.Primitive.load` returned; shared by all of its runs.
    """

    cls: type[Primitive[Any]]
    config: Mapping[str, Any]
    resource: Any


class Loader:
    """The primitives of one skill manager, loaded as far as they were wanted.

    Args:
        primitives: Classes by name; may load themselves when they are looked up.
        config: Values of configuration parameters by "module.key".
        pulse: What the watchdog looks at: loading has a limit of its own, longer than that of a tick.
        limit: That limit, wall time [s]; generous where left out.
    """

    def __init__(
        self,
        primitives: Mapping[str, type[Primitive[Any]]],
        config: Mapping[str, Any],
        pulse: Pulse,
        *,
        limit: float | None = None,
    ) -> None:
        self._primitives = primitives
        self._config = config
        self._pulse = pulse
        self._limit = _LIMIT if limit is None else limit
        self._known: dict[str, Loaded | Failure] = {}

    def prepare(self, module: str, context: RunContext) -> None:
        """Loads a primitive, unless that is done already; one that did not load before is tried again."""
        if not isinstance(self._known.get(module), Loaded):
            self._known[module] = self._attempt(module, context)

    def get(self, module: str, context: RunContext) -> Loaded | Failure:
        """Returns a primitive, loaded, or why it did not load."""
        if module not in self._known:
            self.prepare(module, context)
        return self._known[module]

    def reset(self, module: str, context: RunContext) -> None:
        """Makes a primitive fit to run again after a fault; where that fails, it is loaded again for the next run.

        Raises:
            ModuleError: Its code broke.
        """
        loaded = self._known.pop(module, None)
        if not isinstance(loaded, Loaded):
            return
        resource = contained(f"{module}, when it was reset,", lambda: (loaded.cls.reset(context, loaded.resource),))
        if isinstance(resource, Failure):
            raise ModuleError(resource.reason)
        self._known[module] = replace(loaded, resource=resource[0])

    def _attempt(self, module: str, context: RunContext) -> Loaded | Failure:
        try:
            return self._watched(module, context)
        except KeyboardInterrupt:
            raise
        except CycleOverrun:  # the watchdog has reported it and halted everything
            return Failure(f"{module} did not load within {self._limit:g} s", BROKEN)
        except BaseException as error:  # noqa: BLE001 - an author's mistake makes runs of this one fail, and no other
            _log.exception("primitive %s did not load", module)
            return Failure(f"{module} did not load: {words(error)}", BROKEN)

    def _watched(self, module: str, context: RunContext) -> Loaded:
        outer = self._pulse.enter(Chore(f"the loading of {module}", interruptible=True))
        try:
            with self._pulse.allowing(self._limit):
                cls = self._primitives[module]
                config = configuration_of(module, cls, self._config, context.world)
                return Loaded(cls, config, cls.load(context))
        finally:
            self._pulse.leave(outer)
