"""``skiros skills``: what was found through entry points."""

from __future__ import annotations

from collections.abc import Iterator

import click

from skiros_py.catalogue import Catalogue, load_catalogue
from skiros_py.cli.commands import Found, reports
from skiros_py.errors import escaped
from skiros_py.plugins.plugin import by_cause
from skiros_py.skills.behaviour import lines
from skiros_py.skills.skill import SkillDescription

_CONDITIONS = ("pre", "hold", "post")


@reports("skills --json")
def command() -> Found:
    """Lists skills with their conditions, primitives, conditions, reasoners, and plug-ins that did not load."""
    catalogue = load_catalogue()
    catalogue.load_all()
    skills = {
        name: {
            "skill": skill.description.name,
            "driver": skill.driver,
            "version": skill.version,
            "from": catalogue.sources[f"skills/{name}"],
            "help": skill.description.help,
            **_conditions(skill.description),
        }
        for name, skill in catalogue.skills.items()
    }
    found = {
        "skills": skills,
        "primitives": sorted(catalogue.primitives),
        "conditions": {name: type_.help for name, type_ in catalogue.conditions.items()},
        "reasoners": {reasoner.name: sorted(reasoner.relations) for reasoner in catalogue.reasoners},
        "faults": [
            {"name": f.name, "from": f.distribution, "reason": f.reason, "origin": f.origin} for f in catalogue.faults
        ],
    }
    return found, _lines(catalogue)


def _conditions(description: SkillDescription) -> dict[str, list[str]]:
    return {kind: [str(condition) for condition in getattr(description, kind)] for kind in _CONDITIONS}


def _lines(catalogue: Catalogue) -> Iterator[str]:
    for name, skill in catalogue.skills.items():
        kind = "fake" if skill.driver == "fake" else "real"
        yield f"{name} {skill.version} ({kind}, from {catalogue.sources[f'skills/{name}']}): {skill.description.help}"
        for title, conditions in _conditions(skill.description).items():
            yield from (f"  {title:5} {condition}" for condition in conditions)
        yield from (f"  does  {line}" for line in lines(skill.body))
    yield f"primitives: {', '.join(catalogue.primitives)}"
    for name, type_ in catalogue.conditions.items():
        roles = ", ".join(f"{role.name}: {role.class_.partition(':')[2]}" for role in type_.roles)
        yield f"condition {name}({roles}): {type_.help}"
    for reasoner in catalogue.reasoners:
        yield f"reasoner {reasoner.name} computes {', '.join(sorted(reasoner.relations)) or 'no relation'}"
    for fault in by_cause(catalogue.faults):
        line = f"did not load: {fault.group} {fault.name} of {fault.distribution}: {fault.reason}"
        click.echo(escaped(line), err=True)
