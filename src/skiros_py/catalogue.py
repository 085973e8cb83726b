"""What plug-ins brought, checked before it is used."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from skiros_py.plugins import Plugin, PluginFault, load_plugins
from skiros_py.skills.conditions import ConditionType
from skiros_py.skills.lint import problems_of
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill
from skiros_py.world.ontology import Ontology

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


_IS_ONE: Mapping[str, Callable[[Any], bool]] = {
    "skills": lambda value: isinstance(value, Skill),
    "primitives": lambda value: isinstance(value, type) and issubclass(value, Primitive),
    "conditions": lambda value: isinstance(value, ConditionType),
    "planners": callable,
}
"""What an entry point of each group must name."""


def _fault(plugin: Plugin, reason: str) -> PluginFault:
    return PluginFault(plugin.group, plugin.name, plugin.distribution, reason, "")


def load_catalogue() -> Catalogue:
    """Loads all plug-ins of the groups ``skiros.skills``, ``.primitives``, ``.conditions`` and ``.planners``."""
    found: dict[str, dict[str, Any]] = {}
    sources: dict[str, str] = {}
    faults: list[PluginFault] = []
    for kind in ("skills", "primitives", "conditions", "planners"):
        plugins, broken = load_plugins(f"skiros.{kind}")
        good = [plugin for plugin in plugins if _IS_ONE[kind](plugin.value)]
        found[kind] = {plugin.name: plugin.value for plugin in good}
        sources |= {f"{kind}/{plugin.name}": plugin.distribution for plugin in good}
        faults += broken
        faults += [_fault(p, f"it is a {type(p.value).__name__}, nothing for {kind}") for p in plugins if p not in good]
    return Catalogue(
        found["skills"], found["primitives"], found["conditions"], found["planners"], sources, tuple(faults)
    )


def fitting(catalogue: Catalogue, ontology: Ontology) -> Catalogue:
    """Leaves out skills that say what no ontology declares; they are reported and hurt nobody else."""
    found = {name: problems_of(skill, ontology, catalogue.primitives) for name, skill in catalogue.skills.items()}
    faults = tuple(
        PluginFault("skiros.skills", name, catalogue.sources.get(f"skills/{name}", "this catalogue"), "; ".join(p), "")
        for name, p in found.items()
        if p
    )
    good = {name: skill for name, skill in catalogue.skills.items() if not found[name]}
    return replace(catalogue, skills=good, faults=catalogue.faults + faults)
