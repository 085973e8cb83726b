"""``skiros new``: packages, and what goes into them, from a few words of their author."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import Field, fields, replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from skiros_py.cli.commands import Found, reports
from skiros_py.cli.output import rendered
from skiros_py.scaffold.orders import (
    NewCondition,
    NewOntology,
    NewPackage,
    NewPrimitive,
    NewRobot,
    NewScene,
    NewSkill,
    Order,
    is_urdf,
)

if TYPE_CHECKING:
    from skiros_py.scaffold.draft import Draft


@click.group("new")
def command() -> None:
    """Writes a package, or into one a skill, primitive, condition, ontology, robot or scene, each with its test.

    What is written works and is tested at once: `pytest` runs it on a fake robot. Nothing is ever overwritten. On a
    terminal, what is needed and not given is asked for.
    """


@click.option("--dir", "folder", default=".", type=click.Path(path_type=Path), metavar="DIR", help="Write below DIR.")
def package(folder: Path, dry_run: bool, **given: Any) -> Found:
    """Writes the files of a new package."""
    from skiros_py.scaffold.package import draft_package

    draft = draft_package(folder.absolute(), NewPackage(**given))
    if not dry_run:
        draft.write()
    steps = (f"cd {draft.root}", "pip install -e '.[test]'", "pytest", f"skiros run {given['name']} --fake")
    return _found(draft, steps, dry_run=dry_run)


def _addition(kind: str, order: type[Order]) -> Any:
    """Returns the function of a command that adds to the package around the working directory."""

    def add(dry_run: bool, **given: Any) -> Found:
        from skiros_py.scaffold.project import Project, knowledge_of

        if sys.stdin.isatty() and not any(all(given[name] for name in names) for names in order.enough):
            _ask(order, given)
        if kind == "robot" and is_urdf(given["name"]):
            return _robot_from_urdf(NewRobot(**given), dry_run=dry_run)
        make = getattr(import_module(f"skiros_py.scaffold.{kind}"), f"draft_{kind}")
        with knowledge_of(Project.around(Path.cwd())) as known:
            draft: Draft = make(known, order(**given))
        draft.check() if dry_run else draft.write()
        steps = [f"cd {draft.root}"] if draft.root != Path.cwd() else []
        steps += [f"pytest {path}" for path in draft.new if path.startswith("tests/") and path.endswith(".py")]
        steps += ["pip install -e ."] if draft.changed else []
        return _found(draft, steps, dry_run=dry_run)

    return add


def _robot_from_urdf(said: NewRobot, *, dry_run: bool) -> Found:
    """Writes a robot from a URDF; what it does not tell is asked for on a terminal."""
    from skiros_py.scaffold.robot import draft_from_urdf
    from skiros_py.scaffold.robot_model import Undecided

    while True:
        try:
            draft = draft_from_urdf(Path.cwd(), said)
            break
        except Undecided as missing:
            if not sys.stdin.isatty():
                raise
            answer = click.prompt(missing.question, err=True)
            said = replace(said, arm=answer) if missing.option == "arm" else replace(said, gripper=answer)
    draft.check() if dry_run else draft.write()
    scene = next(Path(path).stem for path in draft.new if "/scenes/" in path and path.endswith(".ttl"))
    steps = [f"cd {draft.root}"] if draft.root != Path.cwd() else []
    return _found(draft, [*steps, "pip install -e '.[test]'", "pytest", f"skiros run {scene}"], dry_run=dry_run)


def _add_command(order: type[Order]) -> None:
    kind = order.__name__.removeprefix("New").lower()
    function = package if order is NewPackage else _addition(kind, order)
    function = click.option("--dry-run", is_flag=True, help="Write nothing; show what would be written.")(function)
    for one in reversed(fields(order)):
        function = _option(one)(function) if one.metadata else click.argument(one.name)(function)
    reports(f"new {order.example}", command, help=order.__doc__)(function)


def _option(field: Field[Any]) -> Any:
    said, default = field.metadata, field.default
    shape: Mapping[str, Any] = (
        {"is_flag": True} if default is False else {"metavar": said["metavar"], "multiple": default == ()}
    )
    return click.option(said["flag"], field.name, default=default, help=said["help"], **shape)


for _order in (NewPackage, NewSkill, NewPrimitive, NewCondition, NewOntology, NewRobot, NewScene):
    _add_command(_order)


def _ask(order: type[Order], given: dict[str, Any]) -> None:
    """Prompts for missing values; for a repeatable one until the answer is empty."""
    for field in fields(order):
        question, name = field.metadata.get("ask"), field.name
        if not question or given[name] or given.get(field.metadata.get("unless", "")):
            continue
        if field.default != ():
            default = None if field.metadata.get("needed") else ""
            given[name] = click.prompt(question, default=default, show_default=False, err=True)
            continue
        while answer := click.prompt(f"{question}, or nothing", default="", show_default=False, err=True):
            given[name] += (answer,)


def _found(draft: Draft, steps: Sequence[str], *, dry_run: bool) -> Found:
    lines = [*_tree(draft), *(f"note: {note}" for note in draft.notes)]
    if dry_run:
        lines.append("nothing was written")
    elif steps:
        lines += ["next:", *(f"    {step}" for step in steps)]
    found = {
        "folder": draft.root,
        "new": [*draft.new, *draft.copied],
        "changed": list(draft.changed),
        "notes": draft.notes,
        "next": steps,
        "written": not dry_run,
    }
    return found, lines


def _tree(draft: Draft) -> list[str]:
    from rich.tree import Tree

    tree = Tree(str(draft.root))
    nodes = {Path(): tree}
    for path in sorted((*draft.new, *draft.changed, *draft.copied)):
        for part in (*reversed(Path(path).parents), Path(path)):
            if part not in nodes:
                mark = " (changed)" if str(part) in draft.changed else ""
                nodes[part] = nodes[part.parent].add(f"{part.name}{mark}")
    return rendered(tree)
