"""What a body refers to must be there: parameters of the skill, and the elements of the loops around."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from skiros_py.errors import DescriptionError, UnknownName
from skiros_py.skills.behaviour import Behaviour, Uses


def check_references(root: Behaviour, keys: Collection[str], where: str) -> None:
    """Looks whether a node and all below it refer to parameters that are there.

    Args:
        root: The node.
        keys: What it may refer to.
        where: Whose it is, for messages ("of skill 'pick'").

    Raises:
        UnknownName: It refers to something else.
        DescriptionError: A loop calls its element as something is called that is there already.
    """
    uses = root.uses()
    for name, asker in _asked(uses):
        if name not in keys:
            raise UnknownName("parameter", name, keys, where=f"in {asker} {where}")
    for name in uses.binds:
        if name in keys:
            raise DescriptionError(f"for each {name} {where}: something else is called so; choose another key")
    keys = {*keys, *uses.binds}
    for child in root.named_children().values():
        check_references(child, keys, where)


def _asked(uses: Uses) -> Iterator[tuple[str, str]]:
    """Yields the names that a behaviour itself refers to, and which part of it does so."""
    yield from uses.names
    yield from ((name, str(condition)) for condition in uses.conditions for name in condition.arguments)
