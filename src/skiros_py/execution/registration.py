"""The world model's record of the skills and primitives that a manager offers."""

from __future__ import annotations

import json
from collections.abc import Iterable
from itertools import chain

from skiros_py.execution.modules import ModuleInfo
from skiros_py.messages import Message
from skiros_py.world.vocabulary import HAS_PRIMITIVE, HAS_SKILL, MODULE_DESCRIPTION, PRIMITIVE, SKILL, VERSION
from skiros_py.world.world import World

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

    def write(self, modules: Iterable[ModuleInfo], *, adopt: bool = False) -> None:
        """Writes what the subsystem can do.

        Args:
            modules: What that is.
            adopt: True where what is written of it already was left by a program that has ended: what is still so
                stays, the rest goes, and where nothing is different nothing is changed.
        """
        offered = tuple(modules)
        left = self._left_behind() if adopt else {}
        if not (offered or left):
            return
        with self._world.transaction(author=self._author, reason=Message("registers what it can do")) as tx:
            for info in offered:
                class_, relation = _WORDS[info.kind]
                same = left.get((class_, info.name))
                module = same.pop() if same else tx.add(class_, label=info.name)
                tx.set(module, VERSION, info.version)
                tx.set(module, MODULE_DESCRIPTION, json.dumps(info.as_json()))
                tx.relate(self._agent, relation, module)
                self._written.append(module)
            for module in chain.from_iterable(left.values()):
                tx.remove(module)

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

    def _left_behind(self) -> dict[tuple[str, str], list[str]]:
        """Returns what is written already, by class and name; those of one name by id, the first one last."""
        found: dict[tuple[str, str], list[str]] = {}
        for class_, relation in _WORDS.values():
            for module in reversed(self._world.objects(self._agent, relation)):
                found.setdefault((class_, self._world.element(module).label), []).append(module)
        return found

    @property
    def _author(self) -> str:
        return f"skill manager {self._agent}"
