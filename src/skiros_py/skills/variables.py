"""Which names a pattern leaves open: what must be bound before it can be asked."""

from __future__ import annotations

from typing import Any

from skiros_py.skills.conditions import AllOf, AnyOf, Exists, Not, Pattern


def variables(pattern: Pattern) -> tuple[str, ...]:
    """Returns the names of a pattern's free variables, each once, as they come."""
    return tuple(dict.fromkeys(_all(pattern)))


def _all(pattern: Pattern) -> list[str]:
    match pattern:
        case Not(inner):
            return _all(inner)
        case AllOf(patterns) | AnyOf(patterns):
            return [name for part in patterns for name in _all(part)]
        case Exists(variable, _, inner):
            return [name for name in _all(inner) if name != variable]
        case _:
            noted = _Noted()
            pattern.rename(noted)
            return noted.names


class _Noted(dict[str, str]):
    """New names for none; notes for which of its variables a pattern looks one up."""

    def __init__(self) -> None:
        super().__init__()
        self.names: list[str] = []

    def get(self, name: str, default: Any = None) -> Any:
        self.names.append(name)
        return default
