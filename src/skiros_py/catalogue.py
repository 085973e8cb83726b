"""What plug-ins brought, checked before it is used."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from skiros_py.config import ontology_paths
from skiros_py.errors import FileError, PlanningError
from skiros_py.planning.actions import actions_of, maintain_emptiness
from skiros_py.plugins import Plugin, PluginFault, load_plugins
from skiros_py.skills.conditions import ConditionType
from skiros_py.skills.lint import problems_of
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill
from skiros_py.world.ontology import Ontology, load_installed
from skiros_py.world.reasoners.plugins import load_reasoners
from skiros_py.world.reasoners.registry import NO_REASONERS, Reasoners

__all__ = ["Catalogue", "fitting", "load_catalogue"]


@dataclass(frozen=True, slots=True)
class Catalogue:
    """What plug-ins brought: skills, primitives and conditions; and the faults of those that did not load."""

    skills: Mapping[str, Skill]
    primitives: Mapping[str, type[Primitive[Any]]]
    conditions: Mapping[str, ConditionType]
    planners: Mapping[str, Any]
    sources: Mapping[str, str]
    faults: tuple[PluginFault, ...]
    reasoners: Reasoners = NO_REASONERS


_IS_ONE: Mapping[str, Callable[[Any], bool]] = {
    "skills": lambda value: isinstance(value, Skill),
    "primitives": lambda value: isinstance(value, type) and issubclass(value, Primitive),
    "conditions": lambda value: isinstance(value, ConditionType),
    "planners": callable,
}
"""What an entry point of each group must name."""


def _fault(plugin: Plugin, reason: str) -> PluginFault:
    return PluginFault(plugin.group, plugin.name, plugin.distribution, reason, "")


def _clashes(plugins: Sequence[Plugin]) -> Iterator[PluginFault]:
    """Yields a fault for each entry point that another hides, or whose object is called otherwise."""
    last = {plugin.name: plugin for plugin in plugins}
    for plugin in plugins:
        if last[plugin.name] is not plugin:
            yield _fault(plugin, f"hidden by the one of the same name from {last[plugin.name].distribution}")
        own = getattr(plugin.value, "name", plugin.name)
        if plugin.group == "skiros.primitives" and own != plugin.name:
            yield _fault(plugin, f"it calls itself '{own}': compositions find it as '{plugin.name}'")


def load_catalogue() -> Catalogue:
    """Loads all plug-ins of the groups ``skiros.skills``, ``.primitives``, ``.conditions`` and ``.planners``.

    The reasoners are those that worlds are opened with; the faults of the plug-ins of ``skiros.reasoners`` and
    ``skiros.ontologies`` are among the faults.
    """
    found: dict[str, dict[str, Any]] = {}
    sources: dict[str, str] = {}
    faults: list[PluginFault] = []
    for kind in ("skills", "primitives", "conditions", "planners"):
        plugins, broken = load_plugins(f"skiros.{kind}")
        faults += _clashes(plugins)
        good = [plugin for plugin in plugins if _IS_ONE[kind](plugin.value)]
        found[kind] = {plugin.name: plugin.value for plugin in good}
        sources |= {f"{kind}/{plugin.name}": plugin.distribution for plugin in good}
        faults += broken
        faults += [_fault(p, f"it is a {type(p.value).__name__}, nothing for {kind}") for p in plugins if p not in good]
    ontology, misfits = _installed()
    reasoners, unusable = load_reasoners(ontology)
    faults += [*unusable, *misfits]
    return Catalogue(
        found["skills"], found["primitives"], found["conditions"], found["planners"], sources, tuple(faults), reasoners
    )


def _installed() -> tuple[Ontology | None, tuple[PluginFault, ...]]:
    try:
        return load_installed(ontology_paths())
    except FileError:
        return None, ()  # no plug-in's fault, and said to whoever opens a scene


def fitting(catalogue: Catalogue, ontology: Ontology, reasoners: Reasoners = NO_REASONERS) -> Catalogue:
    """Leaves out skills that cannot be used here; they are reported and hurt nobody else.

    A skill must use words that the ontology declares, relations that a reasoner computes and primitives that exist, and
    it must be possible to plan with it beside those before it.
    """
    good: dict[str, Skill] = {}
    faults: list[PluginFault] = []
    for name, skill in catalogue.skills.items():
        problems = problems_of(skill, ontology, catalogue.primitives, reasoners)
        problems = problems or _unplannable([*good.values(), skill], ontology)
        if problems:
            source = catalogue.sources.get(f"skills/{name}", "this catalogue")
            faults.append(PluginFault("skiros.skills", name, source, "; ".join(problems), ""))
        else:
            good[name] = skill
    return replace(catalogue, skills=good, faults=(*catalogue.faults, *faults))


def _unplannable(skills: Sequence[Skill], ontology: Ontology) -> tuple[str, ...]:
    descriptions = {skill.description.name: skill.description for skill in skills}
    try:
        maintain_emptiness((a for d in descriptions.values() for a in actions_of(d, ontology)), ontology)
    except PlanningError as error:
        return (str(error),)
    return ()
