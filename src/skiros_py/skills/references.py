"""What a body refers to must be there: parameters of the skill, and the elements of the loops around."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from skiros_py.errors import DescriptionError, UnknownName
from skiros_py.skills.composition import Check, Do, ForEach, Guard, Node, P, children_of
from skiros_py.skills.variables import variables

__all__ = ["check_references"]


def check_references(root: Node, keys: Collection[str], where: str) -> None:
    """Looks whether a node and all below it refer to parameters that are there.

    Args:
        root: The node.
        keys: What it may refer to.
        where: Whose it is, for messages ("of skill 'pick'").

    Raises:
        UnknownName: It refers to something else.
        DescriptionError: A loop calls its element as something is called that is there already.
    """
    for name, asker in _asked(root):
        if name not in keys:
            raise UnknownName("parameter", name, keys, where=f"in {asker} {where}")
    if isinstance(root, ForEach):
        if root.key in keys:
            raise DescriptionError(f"for each {root.key} {where}: something else is called so; choose another key")
        keys = {*keys, root.key}
    for child in children_of(root):
        check_references(child, keys, where)


def _asked(node: Node) -> Iterator[tuple[str, str]]:
    """Yields the names that a node itself refers to, and what of it does so."""
    match node:
        case Do(module, arguments):
            yield from ((value.key, f"the call of '{module}'") for value in arguments.values() if isinstance(value, P))
        case Guard(_, conditions) | Check(conditions):
            yield from ((name, str(condition)) for condition in conditions for name in condition.arguments)
        case ForEach(key, _, _, pattern) if pattern is not None:
            yield from ((name, f"'for each {key}'") for name in variables(pattern) if name != key)
        case _:
            pass
