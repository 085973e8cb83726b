"""How a skill's body calls primitives: which of its parameters is which of theirs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from skiros_py.errors import UsageError
from skiros_py.scaffold.declared import Declared
from skiros_py.scaffold.knowledge import Knowledge
from skiros_py.scaffold.rendering import literal
from skiros_py.skills.parameters import Kind, Param


def calls_of(known: Knowledge, primitives: Sequence[str], params: Sequence[Declared]) -> list[list[str]]:
    """Returns the arguments of one ``Do.of`` per primitive.

    A parameter of a primitive gets the skill's of the same name, whatever its capitals, else the only one of a class
    that fits.

    Raises:
        UnknownName: There is no such primitive.
        UsageError: Nothing fits a parameter that must be given, or several do.
    """
    return [[literal(name), *_arguments(known, name, params)] for name in primitives]


def _arguments(known: Knowledge, primitive: str, params: Sequence[Declared]) -> Iterator[str]:
    for param in known.primitive(primitive):
        found = _fitting(known, param, params)
        if len(found) == 1:
            yield f"{param.key}=P({literal(found[0].key)})"
        elif param.kind in (Kind.ONLINE, Kind.HARDWARE, Kind.PLANNING):
            fit = f"{', '.join(p.key for p in found)} all fit" if found else "no parameter of the skill fits"
            raise UsageError(
                f"--do {primitive}: it needs {param.key} ({param.type}: {param.help}), and {fit}; declare --param"
                f" {param.key}:{param.type}"
            )


def _fitting(known: Knowledge, param: Param, params: Sequence[Declared]) -> list[Declared]:
    able = [p for p in params if _fits(known, p, param)]
    named = [p for p in able if p.key.casefold() == param.key.casefold()]
    return named or (able if param.is_element else [])


def _fits(known: Knowledge, own: Declared, param: Param) -> bool:
    if not isinstance(param.type, str):
        return False
    if own.is_element and param.is_element:
        return known.ontology.is_a(own.type, param.type)
    return own.type == param.type
