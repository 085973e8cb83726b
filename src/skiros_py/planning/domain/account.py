"""Describes for skill authors how their skills were translated into a planning domain: additions, and reasons."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from skiros_py.planning.domain.model import Action
from skiros_py.skills.skill import SkillDescription


@dataclass(frozen=True, slots=True)
class ActionAccount:
    """One action of the domain.

    Attributes:
        name: Its name in the domain.
        parameters: Its parameters, each with its class: "Ball: tiny:Ball".
        notes: What was added to or removed from the author's skill, and why.
    """

    name: str
    parameters: tuple[str, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class SkillAccount:
    """One skill, or the bookkeeping of the goal.

    Attributes:
        skill: Its name; empty for the bookkeeping.
        pre, hold, post: The conditions its author wrote.
        actions: The resulting actions; none if the goal cannot need it.
    """

    skill: str
    pre: tuple[str, ...]
    hold: tuple[str, ...]
    post: tuple[str, ...]
    actions: tuple[ActionAccount, ...]

    def as_json(self) -> dict[str, Any]:
        """Returns the same as plain data."""
        actions = [{"name": a.name, "parameters": list(a.parameters), "notes": list(a.notes)} for a in self.actions]
        written = {"pre": list(self.pre), "hold": list(self.hold), "post": list(self.post)}
        return {"skill": self.skill, **written, "actions": actions}


def account_of(skills: Iterable[SkillDescription], actions: Sequence[tuple[str, Action]]) -> tuple[SkillAccount, ...]:
    """Describes the translation skill by skill.

    Args:
        skills: The skills.
        actions: The actions of the domain, each with its name there.
    """
    told = tuple(
        SkillAccount(
            skill.name,
            tuple(map(str, skill.pre)),
            tuple(map(str, skill.hold)),
            tuple(map(str, skill.post)),
            _actions(skill.name, actions),
        )
        for skill in skills
    )
    bookkeeping = _actions(None, actions)
    return (*told, SkillAccount("", (), (), (), bookkeeping)) if bookkeeping else told


def _actions(skill: str | None, actions: Sequence[tuple[str, Action]]) -> tuple[ActionAccount, ...]:
    return tuple(
        ActionAccount(name, tuple(f"{v.name.lstrip('?')}: {v.type or 'anything'}" for v in a.parameters), a.notes)
        for name, a in actions
        if a.skill == skill
    )
