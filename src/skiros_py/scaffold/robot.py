"""The available robots, and a new one: individuals of a mobile manipulator, with names and limits of its own."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from skiros_py.config import scene_names
from skiros_py.errors import FileError, UnknownName, UsageError
from skiros_py.plugins.installation import installation
from skiros_py.plugins.plugin import PluginFault
from skiros_py.ports.kinematics import GROUP
from skiros_py.scaffold.declared import constant_name, module_name, sentence, snake_case, words_of
from skiros_py.scaffold.draft import Draft, render
from skiros_py.scaffold.orders import NewRobot
from skiros_py.scaffold.project import Knowledge, Project
from skiros_py.scaffold.robot_model import RobotDescription, find_urdf, read_srdf
from skiros_py.world.names import STANDARD_PREFIXES
from skiros_py.world.ontology import Ontology
from skiros_py.world.ontology.documents import Document
from skiros_py.world.scene.files import documents_of
from skiros_py.world.vocabulary import ROBOT

_TYPE = STANDARD_PREFIXES["rdf"] + "type"


def robot_iris(ontology: Ontology) -> dict[str, str]:
    """Returns the IRIs that scenes import for the shipped robots and those of plug-ins, by their last part."""
    robot = ontology.names.iri(ROBOT)
    return {
        document.iri.rpartition("/")[2]: document.iri
        for document in (*ontology.sources, *_of_plugins())
        if any(t.predicate.value == _TYPE and getattr(t.object, "value", "") == robot for t in document.triples)
    }


def _of_plugins() -> Iterator[Document]:
    for entry in installation().of(GROUP):
        yield from (found for found in documents_of(entry) if not isinstance(found, PluginFault))


_LIMITS = {
    "max-linear": 0.8,
    "max-angular": 1.2,
    "max-linear-acceleration": 0.5,
    "max-angular-acceleration": 1.5,
    "max-gap": 0.08,
    "max-force": 60.0,
}
"""Limits [m/s, rad/s, m/s², rad/s², m, N] of the robot that is taken as a pattern."""


def draft_robot(known: Knowledge, said: NewRobot) -> Draft:
    """Writes a robot's individuals and a test that a scene with it comes up; and the entry point for all robots.

    Raises:
        UsageError: An option is not valid; the text explains what would be.
    """
    name = module_name(said.name, "robot")
    if name in robot_iris(known.ontology):
        raise UsageError(f"there is a robot '{name}' already; choose another name")
    start = module_name(said.start, "--start")
    package = known.project.package
    values = {"name": name, "label": words_of(name), "iri": f"https://example.org/{package}/robots/{name}"}
    new = {
        f"src/{package}/robots/{name}.ttl": render(
            "robot.ttl",
            **values,
            help=sentence(said.help or f"The mobile manipulator {words_of(name)}", "--help-text"),
            start=start,
            model=module_name(said.model, "--model"),
            limits=_limits(said.limits),
        ),
        f"tests/robots/test_{name}.py": render("robot_test.py", **values, start=start),
    }
    return known.project.with_folder("robots").draft(new, known.project)


def _limits(said: tuple[str, ...]) -> dict[str, float]:
    limits = dict(_LIMITS)
    for text in said:
        key, _, value = text.partition("=")
        if key not in limits:
            raise UnknownName("limit", key, _LIMITS)
        try:
            limits[key] = float(value)
        except ValueError:
            limits[key] = math.nan
        if not 0.0 < limits[key] < 1000.0:
            raise UsageError(f"--limit {text}: a number above 0 and below 1000")
    return {key.replace("-", "_"): value for key, value in limits.items()}


def draft_from_urdf(folder: Path, said: NewRobot) -> Draft:
    """Writes a robot from a URDF: model, individuals, tests, and a scene in which it picks and places.

    Args:
        folder: Where the command is called: in a package, which gets the robot, or anywhere, for one of its own.
        said: The author's options.

    Raises:
        Undecided: The files do not tell something; its text says which option does.
        UsageError: An option is not valid, or the robot cannot be used; the text explains why.
        FileError: A file cannot be read or understood.
        MissingExtra: The extra "physics" is not installed.
    """
    from skiros_py.scaffold.robot_urdf import MOUNT, Composer  # SciPy: not for those who only want help

    file = find_urdf(said.name)
    model = RobotDescription(file)
    name = module_name(said.called or snake_case(model.xml.get("name") or file.stem), "--name")
    if any(entry.name == name for entry in installation().of(GROUP)):
        raise UsageError(f"there is a robot '{name}' already; choose another by --name")
    groups, notes = _groups(file, said.srdf, model)
    arm = model.arm(said.arm, groups)
    made = Composer(model, arm, model.gripper(arm[-1].child, said.gripper), name, said.base).compose()
    made = replace(made, notes=(*made.notes, *notes))
    project, skeleton = _project(folder, name, said)
    package, scene = project.package, f"{name}_cell"
    if scene in scene_names():
        raise UsageError(f"there is a scene '{scene}' already; choose another name by --name")
    at = f"src/{package}/robots/{name}"
    values = {
        "name": name,
        "constant": constant_name(name),
        "package": package,
        "label": words_of(name),
        "iri": f"https://example.org/{package}/robots/{name}",
        "help": sentence(
            said.help or f"The robot {words_of(name)} on a {'base' if said.base else 'pedestal'}", "--help-text"
        ),
        "base": said.base,
        "docked": round(made.places + MOUNT, 2),
        "source": said.name if ":" in said.name else file.name,
        "scene": scene,
        "made": made,
        "home": " ".join(f"{angle:g}" for angle in made.home),
        "load_centre": " ".join(f"{float(one):.4f}" for one in made.load[1]),
    }
    new = {
        f"{at}/__init__.py": render("urdf_robot.py", **values),
        f"{at}/{name}.urdf": ET.tostring(made.urdf, encoding="unicode", xml_declaration=True) + "\n",
        f"{at}/{name}.ttl": render("urdf_robot.ttl", **values),
        f"{at}/README.md": render("urdf_robot.md", **values),
        f"src/{package}/scenes/{scene}.ttl": render("urdf_scene.ttl", **values),
        f"tests/robots/test_{name}.py": render("urdf_robot_test.py", **values),
        **{f"{at}/{mesh}": text for mesh, text in made.texts.items()},
    }
    if not (project.root / f"src/{package}/robots/__init__.py").exists():
        new[f"src/{package}/robots/__init__.py"] = '"""Robots."""\n'
    changed = project.with_entries(GROUP, {name: f"{package}.robots.{name}:{constant_name(name)}"})
    changed = changed.with_folder("scenes").with_dependency("skiros-py[kitting,physics]")
    draft = replace(changed.draft(new, project, made.notes), copied={f"{at}/{n}": f for n, f in made.copied.items()})
    if skeleton:
        draft = replace(draft, new={**skeleton, **draft.new, **draft.changed}, changed={})
    return draft


def _groups(urdf: Path, said: str, model: RobotDescription) -> tuple[dict[str, tuple[str, str]], list[str]]:
    """Returns the chains of a robot's SRDF, the one that was said or one beside its URDF, and notes about it."""
    if said:
        return read_srdf(Path(said), model), []
    for srdf in (urdf.with_suffix(".srdf"), urdf.parent.parent / "srdf" / f"{urdf.stem}.srdf"):
        if srdf.is_file():
            try:
                return read_srdf(srdf, model), [f"{srdf.name} was read; which links may touch is found from the shapes"]
            except FileError as error:
                return {}, [f"not used: {error}"]
    return {}, []


def _project(folder: Path, name: str, said: NewRobot) -> tuple[Project, dict[str, str]]:
    """Returns the package that gets the robot, and the files of a new one."""
    try:
        return Project.around(folder), {}
    except UsageError:
        root = folder.absolute() / name
    if root.exists():
        raise UsageError(f"{root} is there already, and nothing is overwritten")
    help_ = sentence(said.help or f"The robot {words_of(name)}", "--help-text")
    values = {"name": name, "help": help_, "distribution": name.replace("_", "-")}
    toml = render("pyproject.toml", **values)
    toml = toml[: toml.index("\n# What skiros-py finds")] + "\n"
    skeleton = {
        "pyproject.toml": toml,
        "README.md": render("urdf_readme.md", **values),
        f"src/{name}/__init__.py": f'"""{help_}"""\n',
        f"src/{name}/py.typed": "",
        "tests/conftest.py": render("conftest.py", **values),
    }
    return Project(root, name, toml), skeleton
