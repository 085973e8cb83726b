"""Runs a module by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, ClassVar

from skiros_py.skills.behaviour import Behaviour, Call, Out, P, Scope, Uses, check_texts, require
from skiros_py.skills.outcome import Execution, Outcome


@dataclass(frozen=True, slots=True)
class Do(Behaviour):
    """Runs a module: a primitive, or another skill whose unspecified parameters are inferred when its turn comes.

    Attributes:
        module: Its name.
        arguments: Its parameters: constants, :class:`P` for a parameter of the skill, or :class:`Out` to write a value
            of its outcome. The key is the module's own name for it, so parameters are renamed on the way:
            ``Do.of("pick", Object=P("Part"))``.
    """

    kind: ClassVar[str] = "do"

    module: str
    arguments: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    def __post_init__(self) -> None:
        check_texts("do", "the name of a module", self.module)
        require(isinstance(self.arguments, Mapping), "do", "its arguments by key", self.arguments)

    @classmethod
    def of(cls, module: str, **arguments: Any) -> Do:
        """Makes one: ``Do.of("locate", camera=P("Camera"), place=P("Container"))``."""
        return cls(module, MappingProxyType(arguments))

    @property
    def title(self) -> str:
        """The call as people write it."""
        return written(self)

    def uses(self) -> Uses:
        """Its call, and the parameters that it passes on."""
        call = Call(self.module, self.arguments)
        where = f"the call of '{self.module}'"
        names = tuple((value.key, where) for value in self.arguments.values() if isinstance(value, P))
        return Uses(calls=(call,), names=names, writes=tuple(call.outputs.values()))

    def run(self, scope: Scope) -> Execution[Outcome]:
        """Runs the module to its end."""
        return scope.call(Call(self.module, self.arguments))


def written(call: Do) -> str:
    """Returns a call as people write it."""
    return f"{call.module}({', '.join(f'{key}={_shown(value)}' for key, value in call.arguments.items())})"


def _shown(value: object) -> object:
    match value:
        case P(key):
            return key
        case Out(name):
            return f"→ {name}"
        case _:
            return value
