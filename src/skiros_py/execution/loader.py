"""Primitives are loaded once per skill manager, when they are first wanted (paper §3.2), with configured values."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from skiros_py.errors import ModuleError, UnknownName
from skiros_py.execution.containment import contained, words
from skiros_py.interruptions import Activity, Chore, CycleOverrun
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import BROKEN, Failure
from skiros_py.skills.parameters import Kind, params_of, read_value
from skiros_py.skills.primitive import Primitive
from skiros_py.world.view import WorldView


def configuration_of(
    module: str, cls: type[Primitive[Any]], given: Mapping[str, Any], view: WorldView
) -> dict[str, Any]:
    """Reads what is given for the configuration parameters of a primitive.

    Args:
        module: Name of the primitive.
        cls: The primitive.
        given: All values that were given, by "module.key".
        view: The world, for elements and classes.

    Raises:
        UnknownName: It has no such configuration parameter.
        UsageError: A value is not of the parameter's type.
    """
    params = {p.key: p for p in params_of(cls.Params) if p.kind is Kind.CONFIG}
    own = {key: value for of, key, value in _split(given) if of == module}
    for key in own:
        if key not in params:
            raise UnknownName("configuration parameter", key, params, where=f"of {module}")
    return {key: read_value(params[key], value, view) for key, value in own.items()}


def check_configuration(
    given: Mapping[str, Any], primitives: Mapping[str, type[Primitive[Any]]], view: WorldView
) -> None:
    """Refuses what no module would ever read: a slip of the pen must not leave a robot with the values it had.

    Args:
        given: All values that were given, by "module.key".
        primitives: All primitives by name; those that something is given for are loaded.
        view: The world, for elements and classes.

    Raises:
        UnknownName: There is no such module, or it has no such configuration parameter.
        UsageError: A value is not of the parameter's type.
    """
    for module in dict.fromkeys(module for module, _, _ in _split(given)):
        if module not in primitives:
            raise UnknownName("primitive", module, primitives, where="in the configuration")
        configuration_of(module, primitives[module], given, view)


def _split(given: Mapping[str, Any]) -> list[tuple[str, str, Any]]:
    """Takes "module.key" apart; names of modules have no dot."""
    parts = {name: name.partition(".") for name in given}
    return [(module, key, given[name]) for name, (module, _, key) in parts.items()]


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
        activity: What the watchdog looks at: loading has a limit of its own, longer than that of a tick.
        limit: That limit, wall time [s]; generous where left out.
    """

    def __init__(
        self,
        primitives: Mapping[str, type[Primitive[Any]]],
        config: Mapping[str, Any],
        activity: Activity,
        *,
        limit: float | None = None,
    ) -> None:
        self._primitives = primitives
        self._config = config
        self._activity = activity
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
        outer = self._activity.enter(Chore(f"the loading of {module}", interruptible=True))
        try:
            with self._activity.allowing(self._limit):
                cls = self._primitives[module]
                config = configuration_of(module, cls, self._config, context.world)
                return Loaded(cls, config, cls.load(context))
        finally:
            self._activity.leave(outer)
