"""What a skill manager writes about itself into the world model, where planners and people find it."""

from __future__ import annotations

import json
from collections.abc import Iterable

from skiros_py.execution.modules import ModuleInfo
from skiros_py.world.vocabulary import HAS_PRIMITIVE, HAS_SKILL, MODULE_DESCRIPTION, PRIMITIVE, SKILL, VERSION
from skiros_py.world.world import World

__all__ = ["Registration"]

_WORDS = {"skill": (SKILL, HAS_SKILL), "primitive": (PRIMITIVE, HAS_PRIMITIVE)}


class Registration:
    """The individuals of one subsystem's modules.

    Args:
        world: Where they are written.
        agent: Id of the subsystem.
    """

    def __init__(self, world: World, agent: str) -> None:
        self._world = world
        self._agent = agent
        self._written: list[str] = []

    def write(self, modules: Iterable[ModuleInfo]) -> None:
        """Writes what the subsystem can do."""
        offered = tuple(modules)
        if not offered:
            return
        with self._world.transaction(author=self._author, reason="registers what it can do") as tx:
            for info in offered:
                class_, relation = _WORDS[info.kind]
                module = tx.add(class_, label=info.name)
                tx.set(module, VERSION, info.version)
                tx.set(module, MODULE_DESCRIPTION, json.dumps(info.as_json()))
                tx.relate(self._agent, relation, module)
                self._written.append(module)

    def withdraw(self, reason: str) -> None:
        """Takes all of that back; may be called twice, and in any thread.

        Args:
            reason: Why, for a person.
        """
        there = [module for module in self._written if self._world.has(module)]
        self._written.clear()
        if there:
            with self._world.transaction(author=self._author, reason=reason) as tx:
                for module in there:
                    tx.remove(module)

    @property
    def _author(self) -> str:
        return f"skill manager {self._agent}"
