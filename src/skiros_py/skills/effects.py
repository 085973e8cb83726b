"""Asserting a skill's postconditions: by whoever sensed them, one by key or all at once (paper §5.3)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from skiros_py.errors import UnknownName
from skiros_py.skills.conditions import Condition
from skiros_py.skills.conditions.effects import effects_of, write_effects
from skiros_py.world.world import World


class Effects:
    """The effects of one run of a skill.

    Args:
        world: The live world.
        post: The postconditions, over the skill's parameters.
        arguments: The skill's parameters in this run; filled in as they become known.
    """

    def __init__(self, world: World, post: Iterable[Condition], arguments: Mapping[str, Any]) -> None:
        self._world = world
        self._post = {condition.key: condition for condition in post}
        self._arguments = arguments

    def happened(self, *keys: str, author: str, reason: str) -> None:
        """Writes some postconditions into the world: somebody has sensed that they are so.

        Args:
            *keys: Their keys (:attr:`Condition.key`); none at all means every postcondition.
            author: Who sensed it.
            reason: What was sensed ("gap 44 mm, force 30 N").

        Raises:
            UnknownName: The skill has no postcondition of such a key.
            WorldError: The world refused it.
        """
        for key in keys:
            if key not in self._post:
                raise UnknownName("postcondition", key, self._post)
        wanted = [self._post[key] for key in keys] if keys else list(self._post.values())
        with self._world.transaction(author=author, reason=reason) as tx:
            for condition in wanted:
                write_effects(tx, self._world.ontology, effects_of(condition.bind(self._arguments)))
