"""``skiros new``: packages, and what goes into them, from a few words of their author."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from skiros_py.cli.options import JSON
from skiros_py.cli.output import REACHED, answer

if TYPE_CHECKING:
    from skiros_py.scaffold.draft import Draft
    from skiros_py.scaffold.project import Knowledge

_Command = TypeVar("_Command", bound=Callable[..., Any])
_NAME = click.argument("name")
_HELP = click.option("--help-text", "help", default="", metavar="TEXT", help="Description in one sentence.")
_DRY = click.option("--dry-run", is_flag=True, help="Write nothing; show what would be written.")
_ROBOT = click.option(
    "--robot", default="mobile_panda", metavar="NAME", help="The robot there.  [default: mobile_panda]"
)


def _many(name: str, field: str, metavar: str, help_: str) -> Callable[[_Command], _Command]:
    """Returns a repeatable option for a field of the generated files."""
    return click.option(name, field, multiple=True, metavar=metavar, help=f"{help_}; may be repeated.")


@click.group("new")
def command() -> None:
    """Writes a package, or into one a skill, primitive, condition, ontology, robot or scene, each with its test.

    What is written works and is tested at once: `pytest` runs it on a fake robot. Nothing is ever overwritten. On a
    terminal, what is needed and not given is asked for.
    """


@command.command("package", epilog="Example: skiros new package my_scanning")
@_NAME
@_HELP
@click.option("--dir", "folder", default=".", type=click.Path(path_type=Path), metavar="DIR", help="Write below DIR.")
@click.option("--skill", default="", metavar="NAME", help="Its first skill.  [default: inspect, or one that is free]")
@click.option(
    "--primitive", default="", metavar="NAME", help="Its first primitive.  [default: look_at, or one that is free]"
)
@click.option(
    "--condition", default="", metavar="NAME", help="Its first condition.  [default: Inspected, or one that is free]"
)
@_DRY
@JSON
def package(folder: Path, dry_run: bool, as_json: bool, **said: Any) -> int:
    """Writes an ordinary Python distribution NAME with one of everything."""
    from skiros_py.scaffold.package import NewPackage, draft_package

    draft = draft_package(folder.absolute(), NewPackage(**said))
    if not dry_run:
        draft.write_folder()
    steps = (f"cd {draft.root}", "pip install -e '.[test]'", "pytest", f"skiros run {said['name']} --fake")
    return _tell(draft, steps, dry_run=dry_run, as_json=as_json)


@command.command(
    "skill",
    epilog="Example: skiros new skill scan --agent sk:Arm --param Part:sk:Manipulatable --param Station:sk:Station"
    " --pre 'RobotAtLocation(Robot, Station)' --post 'Scanned(Part)' --do read_code",
)
@_NAME
@_HELP
@click.option("--agent", default="", metavar="CLASS", help="The subsystem that does it, such as sk:Arm.")
@_many("--param", "params", "KEY:CLASS", "A parameter, perhaps with ' -- HELP'")
@_many("--pre", "pre", "CONDITION", "What must hold before")
@_many("--post", "post", "CONDITION", "What holds after it")
@_many("--do", "do", "PRIMITIVE", "What it does, in order; without, it is only pretended")
@click.option("--target", default="", metavar="KEY", help="The parameter it is done to.")
@_ROBOT
@_DRY
@JSON
def skill(dry_run: bool, as_json: bool, **said: Any) -> int:
    """Writes a skill NAME, with a test that plans and executes it.

    With the agent come a parameter for it, one for its robot, and the condition that the robot has it.
    """
    from skiros_py.scaffold.skill import NewSkill, draft_skill

    if not (said["agent"] and said["post"]):
        _ask(said, "agent", "Class of the subsystem that does it (such as sk:Arm)")
        _ask_many(said, "params", "Parameter (such as Part:sk:Manipulatable)")
        _ask_many(said, "pre", "What must hold before (such as RobotAtLocation(Robot, Station))")
        _ask_many(said, "post", "What holds after it (such as Inspected(Part))")
        _ask_many(said, "do", "Primitive that does it")
    return _add(lambda known: draft_skill(known, NewSkill(**said)), dry_run=dry_run, as_json=as_json)


@command.command(
    "primitive",
    epilog="Example: skiros new primitive read_code --param camera:sk:Camera --param 'seconds:number=1 [s]'",
)
@_NAME
@_HELP
@_many(
    "--param", "params", "KEY:TYPE", "A parameter of a class, or 'KEY:number=DEFAULT [UNIT]', perhaps with ' -- HELP'"
)
@_ROBOT
@_DRY
@JSON
def primitive(dry_run: bool, as_json: bool, **said: Any) -> int:
    """Writes a primitive NAME that runs on a fake robot, ready for what the device does."""
    from skiros_py.scaffold.primitive import NewPrimitive, draft_primitive

    _ask_many(said, "params", "Parameter (such as camera:sk:Camera)")
    return _add(lambda known: draft_primitive(known, NewPrimitive(**said)), dry_run=dry_run, as_json=as_json)


@command.command(
    "condition", epilog="Example: skiros new condition Scanned --role part:sk:Manipulatable --property scanning:scanned"
)
@_NAME
@_HELP
@_many("--role", "roles", "KEY:CLASS", "An argument; without, those of the relation or property")
@click.option("--property", default="", metavar="PROPERTY", help="The property it is about.")
@click.option("--value", default="", metavar="VALUE", help="What the property must be.  [default: true, or anything]")
@click.option("--relation", default="", metavar="RELATION", help="The relation it is about.")
@click.option("--abstract", is_flag=True, help="A goal may give a class: any thing of it.")
@_DRY
@JSON
def condition(dry_run: bool, as_json: bool, **said: Any) -> int:
    """Writes a condition NAME: a word for goals and skills, made of a relation or a property."""
    from skiros_py.scaffold.condition import NewCondition, draft_condition

    if not said["relation"]:
        _ask(said, "property", "Property it is about (nothing: a relation)", needed=False)
    if not said["property"]:
        _ask(said, "relation", "Relation it is about")
    return _add(lambda known: draft_condition(known, NewCondition(**said)), dry_run=dry_run, as_json=as_json)


@command.command(
    "ontology",
    epilog="Example: skiros new ontology scanning --class Scanner:sk:Device --property scanned:sk:Object:boolean",
)
@_NAME
@_HELP
@_many("--class", "classes", "NAME:PARENT", "A class, perhaps with ' -- HELP'")
@_many("--relation", "relations", "NAME:DOMAIN:RANGE", "A relation")
@_many(
    "--property", "properties", "NAME:DOMAIN:TYPE", "A property: boolean, number, integer, text, pose, vector or class"
)
@_DRY
@JSON
def ontology(dry_run: bool, as_json: bool, **said: Any) -> int:
    """Writes an ontology NAME, whose words have the prefix NAME."""
    from skiros_py.scaffold.ontology import NewOntology, draft_ontology

    if not (said["classes"] or said["relations"] or said["properties"]):
        _ask_many(said, "classes", "Class (such as Scanner:sk:Device)")
        _ask_many(said, "relations", "Relation (such as scannedAt:sk:Manipulatable:sk:Station)")
        _ask_many(said, "properties", "Property (such as scanned:sk:Manipulatable:boolean)")
    return _add(lambda known: draft_ontology(known, NewOntology(**said)), dry_run=dry_run, as_json=as_json)


@command.command("robot", epilog="Example: skiros new robot loader --start dock --limit max-linear=0.5")
@_NAME
@_HELP
@click.option("--start", default="unknown_location", metavar="ID", help="Where it is.  [default: unknown_location]")
@_many("--limit", "limits", "NAME=VALUE", "max-linear, max-angular, max-gap, max-force, max-linear-acceleration, …")
@click.option("--model", default="mobile_panda", metavar="MODEL", help="What drivers build.  [default: mobile_panda]")
@_DRY
@JSON
def robot(dry_run: bool, as_json: bool, **said: Any) -> int:
    """Writes a robot NAME: the individuals of a mobile manipulator, for scenes to import."""
    from skiros_py.scaffold.robot import NewRobot, draft_robot

    return _add(lambda known: draft_robot(known, NewRobot(**said)), dry_run=dry_run, as_json=as_json)


@command.command(
    "scene", epilog="Example: skiros new scene scan_cell --thing part:sk:Manipulatable --goal 'Inspected(part)'"
)
@_NAME
@_HELP
@_ROBOT
@_many("--thing", "things", "KEY:CLASS", "Something that is there")
@_many("--goal", "goals", "CONDITION", "What is wanted, over the things")
@_DRY
@JSON
def scene(dry_run: bool, as_json: bool, **said: Any) -> int:
    """Writes a scene NAME with a robot, things and a goal."""
    from skiros_py.scaffold.scene import NewScene, draft_scene

    if not said["things"]:
        _ask_many(said, "things", "Something that is there (such as part:sk:Manipulatable)")
        _ask_many(said, "goals", "Goal (such as Inspected(part))")
    return _add(lambda known: draft_scene(known, NewScene(**said)), dry_run=dry_run, as_json=as_json)


# ---------------------------------------------------------------- what all have in common


def _add(make: Callable[[Knowledge], Draft], *, dry_run: bool, as_json: bool) -> int:
    """Adds the generated files to the package around the working directory, and lists them."""
    from skiros_py.scaffold.project import Project, knowledge_of

    project = Project.around(Path.cwd())
    with knowledge_of(project) as known:
        draft = make(known)
    draft.check() if dry_run else draft.write()
    tests = [path for path in draft.new if path.startswith("tests/") and path.endswith(".py")]
    again = ("pip install -e .",) if draft.changed else ()
    steps = (f"cd {draft.root}",) if draft.root != Path.cwd() else ()
    return _tell(draft, (*steps, *(f"pytest {test}" for test in tests), *again), dry_run=dry_run, as_json=as_json)


def _tell(draft: Draft, steps: tuple[str, ...], *, dry_run: bool, as_json: bool) -> int:
    if as_json:
        files = {"new": list(draft.new), "changed": list(draft.changed)}
        result = {
            "folder": str(draft.root),
            **files,
            "notes": list(draft.notes),
            "next": list(steps),
            "written": not dry_run,
        }
        answer(result)
        return REACHED
    _print_tree(draft)
    for note in draft.notes:
        click.echo(f"note: {note}")
    if dry_run:
        click.echo("nothing was written")
    elif steps:
        click.echo("\n    ".join(("next:", *steps)))
    return REACHED


def _print_tree(draft: Draft) -> None:
    from rich.console import Console
    from rich.tree import Tree

    tree = Tree(str(draft.root))
    nodes = {Path(): tree}
    for path in sorted((*draft.new, *draft.changed)):
        for part in (*reversed(Path(path).parents), Path(path)):
            if part not in nodes:
                mark = " (changed)" if str(part) in draft.changed else ""
                nodes[part] = nodes[part.parent].add(f"{part.name}{mark}")
    Console(highlight=False, markup=False, width=120).print(tree)


def _on_terminal() -> bool:
    return sys.stdin.isatty()


def _ask(said: dict[str, Any], key: str, question: str, *, needed: bool = True) -> None:
    """Prompts for missing values if a person can answer."""
    if not said[key] and _on_terminal():
        said[key] = click.prompt(question, default=None if needed else "", show_default=False, err=True)


def _ask_many(said: dict[str, Any], key: str, question: str) -> None:
    """Prompts repeatedly until the answer is empty."""
    if said[key] or not _on_terminal():
        return
    answers: list[str] = []
    while answer := click.prompt(f"{question}, or nothing", default="", show_default=False, err=True):
        answers.append(answer)
    said[key] = tuple(answers)
