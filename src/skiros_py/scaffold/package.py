"""Writes a package: an ordinary Python distribution with one item of each kind, made by the respective generators."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from importlib.util import find_spec
from itertools import chain, count
from pathlib import Path
from typing import Any

from skiros_py.errors import UsageError
from skiros_py.scaffold.condition import draft_condition
from skiros_py.scaffold.declared import class_name, joined, module_name, sentence, snake_case, words_of
from skiros_py.scaffold.draft import Draft, render
from skiros_py.scaffold.ontology import draft_ontology
from skiros_py.scaffold.orders import NewCondition, NewOntology, NewPackage, NewPrimitive, NewScene, NewSkill, Order
from skiros_py.scaffold.primitive import draft_primitive
from skiros_py.scaffold.project import Knowledge, Project, knowledge_of, taken_by
from skiros_py.scaffold.scene import draft_scene
from skiros_py.scaffold.skill import draft_skill


def draft_package(folder: Path, said: NewPackage) -> Draft:
    """Makes the files of a package; write them by :meth:`Draft.write`.

    Args:
        folder: The folder in which the package's own folder is created.
        said: The author's options.

    Raises:
        UsageError: An option is not valid; the text explains what would be.
    """
    name = _free_name(said.name)
    if (folder / name).exists():
        raise UsageError(f"{folder / name} is there already, and nothing is overwritten")
    said = replace(said, **{kind: _first(kind, getattr(said, kind), name) for kind in _FIRST})
    with tempfile.TemporaryDirectory(prefix="skiros-new-") as work:
        root = Path(work).resolve() / name
        notes = [note for draft in _built(root, said) for note in draft.notes]
        files = [path for path in root.rglob("*") if path.is_file() and "__pycache__" not in path.parts]
        new = {str(path.relative_to(root)): path.read_text(encoding="utf-8") for path in sorted(files)}
    return Draft(folder / name, new, notes=tuple(notes))


def _free_name(name: str) -> str:
    name = module_name(name, "package")
    if name in _IN_SKELETON:
        raise UsageError(f"package '{name}': every package has tests of that name; choose another")
    if name in sys.stdlib_module_names or find_spec(name) is not None:
        raise UsageError(f"package '{name}': Python finds a module of that name already; choose another")
    return name


_IN_SKELETON = frozenset({"tests", "conftest"})
"""Names by which Python finds a package's tests."""


def _first(kind: str, name: str, package: str) -> str:
    """Returns the name of the first skill, primitive or condition: the one said, if it is free, or else a free one.

    That carries the package's name: two packages never have the same.
    """
    if not name:
        usual = f"{package[:_LONGEST_PART]}_{_FIRST[kind]}"
        usual = joined(usual) if kind == "condition" else usual
        numbered = (f"{usual}{'' if kind == 'condition' else '_'}{number}" for number in count(2))
        return next(free for free in chain((usual,), numbered) if taken_by(kind, free) is None)
    if (holder := taken_by(kind, name)) is not None:
        raise UsageError(f"there is {holder} already; choose another name by --{kind}")
    return name


_FIRST = {"skill": "inspect", "primitive": "look_at", "condition": "inspected"}
"""Names of the first skill, primitive and condition of a package, after that of the package."""
_LONGEST_PART = 30
"""How many letters of a package's name its first names have."""


def _built(root: Path, said: NewPackage) -> Iterator[Draft]:
    """Writes the package piece by piece, each of which knows those before it."""
    skeleton = Draft(root, dict(_skeleton(said)))
    skeleton.write()
    yield skeleton
    for generator, order in _orders(said):
        with knowledge_of(Project.around(root)) as known:
            draft = generator(known, order)
        draft.write()
        yield draft


def _skeleton(said: NewPackage) -> Iterator[tuple[str, str]]:
    help_ = sentence(said.help or f"Skills for {words_of(said.name)}", "--help-text")
    values = {"name": said.name, "help": help_, "distribution": said.name.replace("_", "-"), "skill": said.skill}
    yield "pyproject.toml", render("pyproject.toml", **values)
    yield "README.md", render("README.md", **values)
    yield ".gitignore", "__pycache__/\n*.egg-info/\n.mypy_cache/\n.pytest_cache/\n.ruff_cache/\ndist/\n"
    yield f"src/{said.name}/__init__.py", f'"""{help_}"""\n'
    yield f"src/{said.name}/py.typed", ""
    yield "tests/conftest.py", render("conftest.py", **values)


def _orders(said: NewPackage) -> Iterator[tuple[Callable[[Knowledge, Any], Draft], Order]]:
    """Yields what is written into the package, one after the other, each with its generator."""
    name, word = said.name, class_name(said.condition, "condition")
    first, *rest = snake_case(word.removeprefix(joined(name)) or word).split("_")
    property_ = first + "".join(part.capitalize() for part in rest)
    yield (
        draft_ontology,
        NewOntology(
            name,
            classes=("Marker:sk:Manipulatable -- A part that bears a mark which a camera can read",),
            relations=("handledAt:sk:Manipulatable:sk:Station -- Where the part is worked at",),
            properties=(f"{property_}:sk:Manipulatable:boolean -- True once it was done to the part",),
        ),
    )
    yield draft_condition, NewCondition(word, roles=("part:sk:Manipulatable",), property=f"{name}:{property_}")
    looks = ("camera:sk:Camera -- The camera to look with", "seconds:number=1.0 [s] -- How long it looks")
    yield draft_primitive, NewPrimitive(said.primitive, help="Looks for a while with a camera", params=looks)
    help_, part = "Looks at a part, from where it can be worked at", "part:sk:Manipulatable -- The part."
    skill = NewSkill(said.skill, help_, agent="sk:Arm", params=(part,), post=(f"{word}(part)",), do=(said.primitive,))
    if taken_by("condition", "RobotAtLocation") is not None:  # skills are installed that take the robot there
        station = "station:sk:Station -- Where the part can be worked at."
        skill = replace(skill, params=(part, station), pre=("RobotAtLocation(robot, station)",))
    yield draft_skill, skill
    things = (f"part:{name}:Marker", "station:sk:Station")
    yield draft_scene, NewScene(name, things=things, goals=(f"{word}(part)",))
