"""Names of several distributions: where two use one name for different things, it is qualified ("lab.pick").

What belongs to one distribution goes on finding each other by its own names.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any, TypeVar, cast

from skiros_py.behaviours import Do
from skiros_py.catalogue.catalogue import Named
from skiros_py.plugins.installation import has_bare_name, installation
from skiros_py.plugins.plugin import Entry, Plugin, qualified
from skiros_py.skills.behaviour import Behaviour, Call
from skiros_py.skills.conditions import Condition, ConditionType
from skiros_py.skills.skill import Skill, SkillDescription

T = TypeVar("T")

_Claim = tuple[Any, str, Any]
"""A name, the distribution that uses it, and what it stands for."""


@dataclass
class OfferedNames:
    """The names under which modules and conditions are offered where these are not their own.

    Attributes:
        modules: By distribution, the names of skills and primitives by their own.
        words: By distribution, its conditions with the words under which they are offered.
        ways: Implementations whose label is qualified, by distribution and key.
    """

    modules: dict[str, dict[str, str]] = field(default_factory=dict)
    words: dict[str, list[tuple[ConditionType, str]]] = field(default_factory=dict)
    ways: set[tuple[str, str]] = field(default_factory=set)

    @classmethod
    def of(cls, skills: Sequence[Named], primitives: Sequence[Entry], conditions: Sequence[Named]) -> OfferedNames:
        """Finds the names that need qualifying: used by several distributions for different things."""
        described = [(s.value.description.name, s.plugin.distribution, s.value.description) for s in skills]
        entries = [(entry.name, str(entry.distribution), entry) for entry in primitives]
        worded = [(c.value.name, c.plugin.distribution, c.value) for c in conditions]
        ways = [(_way(s.value), s.plugin.distribution, s.key) for s in skills if s.value.label]
        # By its names, for it is not loaded: else names would change with it, and what people stored with them.
        absent = [(entry.name, str(entry.distribution), entry) for entry in installation().left_out]
        described += [claim for claim in absent if claim[2].group in ("skiros.skills", "skiros.primitives")]
        worded += [claim for claim in absent if claim[2].group == "skiros.conditions"]
        found = cls()
        for own, name, _, holder in _apart([*described, *entries]):
            found.modules.setdefault(own, {})[name] = qualified(name, holder)
        for entry in (entry for entry in primitives if entry.name != entry.own_name):
            found.modules.setdefault(str(entry.distribution), {})[entry.own_name] = entry.name
        for own, name, type_, holder in _apart(worded):
            found.words.setdefault(own, []).append((type_, qualified(name, holder)))
        found.ways.update((own, key) for own, _, key, _ in _apart(ways))
        return found

    def entry(self, entry: Entry) -> Entry:
        """Returns a primitive's entry point under the name that it is offered under."""
        return entry.offered(self.modules.get(str(entry.distribution), {}).get(entry.own_name, entry.name))

    def named(self, thing: Named) -> Named:
        """Returns a skill or condition with the names under which it and what it uses are offered."""
        own, value = thing.plugin.distribution, thing.value
        if (own, thing.key) in self.ways:
            value = replace(value, label=qualified(value.label, own))
        return replace(thing, value=_renamed(value, self.modules.get(own, {}), self.words.get(own, [])))

    def primitive(self, plugin: Plugin) -> type[Any]:
        """Returns a primitive's class; where its distribution has offered names, a subclass that uses them."""
        others = self.modules.get(plugin.distribution)
        return _subclass(plugin.value, name=plugin.name, offered=others) if others else plugin.value


def kind_offered(plugin: Plugin) -> type[Any]:
    """Returns the class of a kind of node or document, under the name that it is offered under."""
    return plugin.value if plugin.name == plugin.own_name else _subclass(plugin.value, kind=plugin.name)


def _subclass(base: type[T], **attributes: Any) -> type[T]:
    shared = {name: getattr(base, name) for name in ("__module__", "__qualname__", "__doc__")}
    return type(base.__name__, (base,), {**shared, **attributes})


def _way(skill: Skill) -> tuple[str, str, str | None]:
    return skill.description.name, skill.label, skill.driver


def _apart(claims: Sequence[_Claim]) -> Iterator[tuple[str, Any, Any, str]]:
    """Yields what gives way to others of the same name: distribution, name, meaning, and who qualifies the name."""
    for name in dict.fromkeys(name for name, _, _ in claims):
        meanings: list[tuple[Any, set[str]]] = []  # a list, for what a name stands for cannot always be hashed
        for distribution, meaning in ((distribution, meaning) for own, distribution, meaning in claims if own == name):
            users = next((users for known, users in meanings if known == meaning), None)
            if users is None:
                meanings.append((meaning, {distribution}))
            else:
                users.add(distribution)
        everyone = {user for _, users in meanings for user in users}
        holders = [min(users, key=lambda one: (not has_bare_name(one, everyone), one)) for _, users in meanings]
        for holder, (meaning, users) in zip(holders, meanings, strict=True):
            if not has_bare_name(holder, holders):
                yield from ((user, name, meaning, holder) for user in sorted(users))


def _renamed(value: Any, modules: Mapping[str, str], words: Sequence[tuple[ConditionType, str]]) -> Any:
    """Returns a skill, or a part of one, with other names of modules and conditions in it."""
    if not modules and not words:
        return value
    if isinstance(value, tuple):
        return tuple(_renamed(one, modules, words) for one in value)
    if not isinstance(value, _RENAMED) or not is_dataclass(value):
        return value
    changed = {one.name: _renamed(getattr(value, one.name), modules, words) for one in fields(value) if one.init}
    match cast(object, value):
        case SkillDescription(name):
            changed["name"] = modules.get(name, name)
            pairs = zip(cast(SkillDescription, value).post, changed["post"], strict=True)
            # by its key, its author's code finds a postcondition
            changed["post"] = tuple(new if new.key == old.key else new.named(old.key) for old, new in pairs)
        case Do(module) | Call(module):
            changed["module"] = modules.get(module, module)
        case ConditionType(name):
            changed["name"] = next((word for type_, word in words if type_ == value), name)
    return replace(value, **changed)


_RENAMED = (Skill, SkillDescription, Behaviour, Call, Condition, ConditionType)
