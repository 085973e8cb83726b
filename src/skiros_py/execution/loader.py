"""Primitives are loaded once per skill manager, when they are first wanted (paper §3.2), with configured values."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from skiros_py.errors import ModuleError, UnknownName
from skiros_py.execution.module_faults import contained, words
from skiros_py.interruptions import Activity, CycleOverrun, CycleStep, by_user
from skiros_py.messages import Message
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import BROKEN, Failure
from skiros_py.skills.parameters import Kind, params_of
from skiros_py.skills.parameters.values import read_value
from skiros_py.skills.primitive import Primitive
from skiros_py.world.view import WorldView


def read_configuration(
    given: Mapping[str, Any], primitives: Mapping[str, type[Primitive[Any]]], view: WorldView
) -> dict[str, dict[str, Any]]:
    """Reads the values that are given for configuration parameters of primitives.

    A value that no module would ever read is refused: a typing error must not leave a robot with the values it had.

    Args:
        given: All values, by "module.key".
        primitives: All primitives by name; those that something is given for are loaded.
        view: The world, for elements and classes.

    Returns:
        The values by module and key.

    Raises:
        UnknownName: There is no such module, or it has no such configuration parameter.
        UsageError: A value is not of the parameter's type.
    """
    read: dict[str, dict[str, Any]] = {}
    for name, value in given.items():
        head, _, tail = name.rpartition(".")  # keys have no dot, names of modules may
        module, key = (head, tail) if head else (tail, "")
        if module not in primitives:
            raise UnknownName("primitive", module, primitives, where="in the configuration")
        params = {p.key: p for p in params_of(primitives[module].Params) if p.kind is Kind.CONFIG}
        if key not in params:
            raise UnknownName("configuration parameter", key, params, where=f"of {module}")
        read.setdefault(module, {})[key] = read_value(params[key], value, view)
    return read


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
        config: Values of configuration parameters by module and key.
        activity: What the watchdog looks at: loading has a limit of its own, longer than that of a tick.
    """

    def __init__(
        self,
        primitives: Mapping[str, type[Primitive[Any]]],
        config: Mapping[str, Mapping[str, Any]],
        activity: Activity,
    ) -> None:
        self._primitives = primitives
        self._config = config
        self._activity = activity
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
        except CycleOverrun:  # the watchdog has reported it and halted everything
            return Failure(Message("{module} did not load within {seconds:g} s", module=module, seconds=_LIMIT), BROKEN)
        except BaseException as error:  # an author's mistake makes runs of this one fail, and no other
            if by_user(error):
                raise
            _log.exception("primitive %s did not load", module)
            return Failure(Message("{module} did not load: {error}", module=module, error=words(error)), BROKEN)

    def _watched(self, module: str, context: RunContext) -> Loaded:
        outer = self._activity.enter(CycleStep(f"the loading of {module}", interruptible=True))
        try:
            with self._activity.allowing(_LIMIT):
                cls = self._primitives[module]
                declared = (*params_of(cls.Params), *(output.param for output in cls.outputs))
                for param in (param for param in declared if param.is_element):
                    context.world.ontology.resolve_class(param.element_class)
                return Loaded(cls, self._config.get(module, {}), cls.load(context))
        finally:
            self._activity.leave(outer)
