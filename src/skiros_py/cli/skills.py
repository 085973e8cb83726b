"""``skiros skills``: what was found through entry points."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from skiros_py.cli.output import answer, escaped

if TYPE_CHECKING:
    from skiros_py.catalogue import Catalogue


@click.command("skills", epilog="Example: skiros skills --json")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def command(as_json: bool) -> int:
    """Lists skills with their conditions, primitives, conditions, reasoners, and plug-ins that did not load."""
    from skiros_py.catalogue import load_catalogue

    catalogue = load_catalogue()
    catalogue.load_all()
    if as_json:
        answer(_as_json(catalogue))
    else:
        _print(catalogue)
    return 0


def _as_json(catalogue: Catalogue) -> dict[str, object]:
    skills = {
        name: {
            "skill": skill.description.name,
            "driver": skill.driver,
            "version": skill.version,
            "from": catalogue.sources[f"skills/{name}"],
            "help": skill.description.help,
            "pre": [str(c) for c in skill.description.pre],
            "hold": [str(c) for c in skill.description.hold],
            "post": [str(c) for c in skill.description.post],
        }
        for name, skill in catalogue.skills.items()
    }
    conditions = {name: type_.help for name, type_ in catalogue.conditions.items()}
    faults = [
        {"name": f.name, "from": f.distribution, "reason": f.reason, "origin": f.origin} for f in catalogue.faults
    ]
    return {
        "skills": skills,
        "primitives": sorted(catalogue.primitives),
        "conditions": conditions,
        "reasoners": {reasoner.name: sorted(reasoner.relations) for reasoner in catalogue.reasoners},
        "faults": faults,
    }


def _print(catalogue: Catalogue) -> None:
    from skiros_py.skills.behaviour import lines

    for name, skill in catalogue.skills.items():
        description = skill.description
        kind = "fake" if skill.driver == "fake" else "real"
        click.echo(f"{name} {skill.version} ({kind}, from {catalogue.sources[f'skills/{name}']}): {description.help}")
        for title, conditions in (("pre", description.pre), ("hold", description.hold), ("post", description.post)):
            for condition in conditions:
                click.echo(f"  {title:5} {condition}")
        for line in lines(skill.body):
            click.echo(f"  does  {line}")
    click.echo(f"primitives: {', '.join(catalogue.primitives)}")
    for name, type_ in catalogue.conditions.items():
        roles = ", ".join(f"{role.name}: {role.class_.partition(':')[2]}" for role in type_.roles)
        click.echo(f"condition {name}({roles}): {type_.help}")
    for reasoner in catalogue.reasoners:
        click.echo(f"reasoner {reasoner.name} computes {', '.join(sorted(reasoner.relations)) or 'no relation'}")
    for fault in catalogue.faults:
        line = f"did not load: {fault.group} {fault.name} of {fault.distribution}: {fault.reason}"
        click.echo(escaped(line), err=True)
