"""Who calls whom: a skill is worth no more than the skills that it calls."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from skiros_py.skills.behaviour import calls_of
from skiros_py.skills.skill import Skill

__all__ = ["called_by", "callers_of_broken"]


def called_by(skill: Skill) -> tuple[str, ...]:
    """Returns the names of the modules that a skill calls, in alphabetical order."""
    return tuple(sorted({call.module for call in calls_of(*skill.nodes)}))


def callers_of_broken(skills: Mapping[str, Skill], broken: Mapping[str, str]) -> dict[str, str]:
    """Finds the skills that call, however indirectly, one of which no implementation can be used.

    Args:
        skills: Implementations by their keys.
        broken: The reasons, by key, why some cannot be used, of these or of others.

    Returns:
        The reasons, by key, why further ones cannot.
    """
    found: dict[str, str] = {}
    while True:
        gone = _gone(skills, {**broken, **found})
        more = {
            key: f"it calls '{name}': {gone[name]}"
            for key, skill in skills.items()
            if key not in broken and key not in found
            for name in _first(called_by(skill), gone)
        }
        if not more:
            return found
        found |= more


def _gone(skills: Mapping[str, Skill], broken: Mapping[str, str]) -> dict[str, str]:
    """Returns why skills are not there at all, by their own names."""
    left = {skill.description.name for key, skill in skills.items() if key not in broken}
    reasons = ((skills[key].description.name, reason) for key, reason in broken.items() if key in skills)
    return {name: reason for name, reason in reasons if name not in left}


def _first(called: Iterable[str], gone: Mapping[str, str]) -> list[str]:
    return [name for name in called if name in gone][:1]
