"""Starts a module that runs on beside the skill."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar

from skiros_py.behaviours.do import Do, written
from skiros_py.skills.behaviour import Call, Scope
from skiros_py.skills.outcome import Execution, Outcome


@dataclass(frozen=True, slots=True)
class Start(Do):
    """Starts a module in the background and goes on at once: what monitors something does not end with the skill.

    One that runs already with the same parameters stays as it is. It ends by itself, or when its skill manager goes.
    """

    kind: ClassVar[str] = "start"

    @classmethod
    def of(cls, module: str, **arguments: Any) -> Start:
        """Makes one: ``Start.of("monitor_battery", robot=P("Robot"))``."""
        return cls(module, MappingProxyType(arguments))

    @property
    def title(self) -> str:
        """The call as people write it."""
        return f"start {written(self)}"

    def run(self, scope: Scope) -> Execution[Outcome]:
        """Starts the module."""
        yield from ()
        return scope.launch(Call(self.module, self.arguments))
