"""Modules that cannot be used: names that mean two things, and skills that call what is broken."""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from skiros_py.plugins import Entry, Plugin
from skiros_py.skills.behaviour import calls_of
from skiros_py.skills.skill import Skill


@dataclass(frozen=True, slots=True)
class Named:
    """Something that an entry point brought.

    Attributes:
        plugin: The entry point, loaded.
        key: Name in the catalogue: that of the entry point, with a number where it names several.
        value: The thing.
    """

    plugin: Plugin
    key: str
    value: Any

    @property
    def origin(self) -> str:
        """Where it is from, for people."""
        return f"{self.key} of {self.plugin.distribution}"


def clashes_of_modules(skills: Sequence[Named], primitives: Collection[Entry]) -> tuple[dict[str, str], dict[str, str]]:
    """Finds skills and primitives whose name compositions cannot use, because it means something else, too.

    Several implementations of one description are no clash. Different descriptions of one name are, and so are two
    implementations of one label for one driver, and a skill and a primitive of one name, for compositions call both.

    Returns:
        The reasons by the keys of the skills, and by the names of the primitives.
    """
    by_name = _by(skills, lambda skill: skill.description.name)
    both = [entry for entry in primitives if entry.name in by_name]
    reasons = {entry.name: _both(entry, by_name[entry.name]) for entry in both}
    of_skills = {one.key: reason for name, reason in reasons.items() for one in by_name[name]}
    for name, own in by_name.items():
        if name not in reasons:
            of_skills |= dict(_among_skills(name, own))
    return of_skills, reasons


def clashes_of_conditions(conditions: Sequence[Named]) -> dict[str, str]:
    """Returns the reasons, by key, why conditions cannot count: their word means something else elsewhere."""
    words = _by(conditions, lambda condition: condition.name)
    return {
        one.key: _twice("condition", word, own)
        for word, own in words.items()
        if any(other.value != own[0].value for other in own)
        for one in own
    }


def _both(primitive: Entry, skills: Sequence[Named]) -> str:
    origins = ", ".join(skill.origin for skill in skills)
    twice = f"'{primitive.name}' is the name of a skill ({origins}) and of a primitive ({primitive})"
    return f"{twice}: neither counts, rename one of them"


def _among_skills(name: str, skills: Sequence[Named]) -> Iterator[tuple[str, str]]:
    if any(one.value.description != skills[0].value.description for one in skills):
        yield from ((one.key, _twice("description of skill", name, skills)) for one in skills)
        return
    labelled = [one for one in skills if one.value.label]  # without a label the entry point's name tells them apart
    for (label, _), own in _by(labelled, lambda skill: (skill.label, skill.driver)).items():
        if len(own) > 1:
            yield from ((one.key, _twice(f"implementation of '{name}' called", label, own)) for one in own)


def _by(things: Sequence[Named], key: Callable[[Any], Hashable]) -> Mapping[Any, list[Named]]:
    groups: dict[Hashable, list[Named]] = {}
    for thing in things:
        groups.setdefault(key(thing.value), []).append(thing)
    return groups


def _twice(kind: str, name: str, things: Sequence[Named]) -> str:
    origins = " and ".join(thing.origin for thing in things)
    return f"there is more than one {kind} '{name}': {origins}; none of them counts, rename one"


# ---------------------------------------------------------------- who calls whom


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
