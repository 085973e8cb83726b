"""A package being written: its ``pyproject.toml``, and the words and modules available to it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tomlkit
from packaging.requirements import InvalidRequirement, Requirement
from tomlkit.exceptions import TOMLKitError

from skiros_py.catalogue import Catalogue, load_catalogue
from skiros_py.config import ontology_paths
from skiros_py.errors import DescriptionError, FileError, UnknownName, UsageError
from skiros_py.files import read_text
from skiros_py.plugins.installation import as_if_installed, installation
from skiros_py.plugins.plugin import Entry, canonical
from skiros_py.scaffold.declared import sentence
from skiros_py.scaffold.draft import Draft, check_names
from skiros_py.skills.conditions import Condition, ConditionType
from skiros_py.skills.parameters import Param, params_of
from skiros_py.world.ontology import Ontology, load_installed

_FILE = "pyproject.toml"
_CONDITION = re.compile(r"(?P<not>not\s+)?(?P<word>[A-Za-z]\w*)\s*\(\s*(?P<arguments>[^()]*)\)")
_FOLDERS = {
    "conditions": "The words in which goals and skills are stated, one in a file.",
    "primitives": "What a robot does, one in a file.",
    "skills": "What can be planned, one in a file.",
}


@dataclass(frozen=True, slots=True)
class Project:
    """One distribution for skiros-py.

    Attributes:
        root: Folder of its ``pyproject.toml``.
        package: Name of its Python package.
        text: Its ``pyproject.toml``.
    """

    root: Path
    package: str
    text: str

    @classmethod
    def around(cls, folder: Path) -> Project:
        """Finds the package that a folder is in.

        Raises:
            UsageError: It is in none, or in one that is not for skiros-py.
            FileError: Its ``pyproject.toml`` cannot be read.
        """
        folder = folder.absolute()
        root = next((f for f in (folder, *folder.parents) if (f / _FILE).is_file()), None)
        if root is None:
            raise UsageError(
                f"{folder} is in no package: there is no {_FILE} here or above; skiros new package makes one"
            )
        text = _read(root / _FILE)
        project = cls(root, _package(root), text)
        if not any(_is_named(requirement, "skiros-py") for requirement in project.dependencies):
            reason = "is not of a package for skiros-py: its [project] has no dependency 'skiros-py'"
            raise FileError(root / _FILE, reason)
        return project

    @property
    def name(self) -> str:
        """Name of the distribution."""
        return str(self._table.get("name", self.package))

    @property
    def dependencies(self) -> tuple[str, ...]:
        """Its dependencies, as declared."""
        needs = self._table.get("dependencies", ())
        return tuple(need for need in needs if isinstance(need, str)) if isinstance(needs, list) else ()

    @property
    def entry_points(self) -> Mapping[str, Mapping[str, Any]]:
        """Its entry points by group."""
        groups = self._table.get("entry-points", {})
        return {group: own for group, own in groups.items() if isinstance(own, Mapping)}

    @property
    def _table(self) -> Mapping[str, Any]:
        table = tomlkit.parse(self.text).unwrap().get("project", {})
        return table if isinstance(table, Mapping) else {}

    def as_installed(self) -> AbstractContextManager[None]:
        """Registers it in this process according to its ``pyproject.toml``, installed or not."""
        known = {"name": self.name, "dependencies": self.dependencies, "entry-points": self.entry_points}
        return as_if_installed({**self._table, **known}, self.root / "src")

    def with_entries(self, group: str, entries: Mapping[str, str]) -> Project:
        """Returns the project with more entry points; everything else in the file stays as it is.

        Raises:
            UsageError: It has one of that name already.
        """
        taken = [name for name in entries if name in self.entry_points.get(group, {})]
        if taken:
            raise UsageError(f"{_FILE} has an entry point '{taken[0]}' of {group} already, and nothing is overwritten")
        document = tomlkit.parse(self.text)
        groups = document["project"].setdefault("entry-points", tomlkit.table(is_super_table=True))
        if group not in groups:
            groups[group] = tomlkit.table()
        for name, value in entries.items():
            groups[group][name] = value
        return Project(self.root, self.package, tomlkit.dumps(document))

    def with_dependency(self, requirement: str) -> Project:
        """Returns the project with one more dependency, unless it has it or is it."""
        name = Requirement(requirement).name
        if _is_named(self.name, name) or any(_is_named(own, name) for own in self.dependencies):
            return self
        document = tomlkit.parse(self.text)
        document["project"]["dependencies"].append(requirement)
        return Project(self.root, self.package, tomlkit.dumps(document))

    def names(self, folder: str, name: str, stem: str, help_: str, **more: str) -> dict[str, str]:
        """Returns what the templates of a new module and its test have in common.

        Args:
            folder: Its folder ("skills").
            name: Name of what it declares.
            stem: Name of the module.
            help_: What it is, in a sentence.
            **more: Further values.

        Raises:
            UsageError: The sentence is not valid.
        """
        module = f"{self.package}.{folder}.{stem}"
        return {"name": name, "help": sentence(help_, "--help-text"), "stem": stem, "module": module, **more}

    def module_draft(
        self,
        folder: str,
        stem: str,
        entries: Mapping[str, str],
        texts: tuple[str, str, str],
        needs: Iterable[str] = (),
        notes: Iterable[str] = (),
    ) -> Draft:
        """Returns a new module with its test and scene.

        Args:
            folder: Its folder ("skills"), which is also the last part of the group of its entry points.
            stem: Its name.
            entries: Names of its objects, by entry point.
            texts: The module, its test and the scene of the test.
            needs: Requirements of the module.
            notes: Notes for the author.

        Raises:
            UsageError: An entry point of that name exists, or a module would define a name twice.
        """
        places = f"src/{self.package}/{folder}/{stem}.py", f"tests/{folder}/test_{stem}.py"
        for path, text in zip(places, texts[:2], strict=True):
            check_names(path, text)
        new = dict(zip((*places, f"tests/{folder}/scenes/{stem}.ttl"), texts, strict=True))
        init = f"src/{self.package}/{folder}/__init__.py"
        if not (self.root / init).exists():
            new[init] = f'"""{_FOLDERS[folder]}"""\n'
        module = f"{self.package}.{folder}.{stem}"
        project = self.with_entries(f"skiros.{folder}", {name: f"{module}:{own}" for name, own in entries.items()})
        for need in needs:
            project = project.with_dependency(need)
        return project.draft(new, self, notes)

    def with_folder(self, folder: str) -> Project:
        """Returns the project with an entry point for all files in a folder of its package ("robots")."""
        group = f"skiros.{folder}"
        return self if self.entry_points.get(group) else self.with_entries(group, {self.package: self.package})

    def draft(self, new: Mapping[str, str], before: Project, notes: Iterable[str] = ()) -> Draft:
        """Returns new files, and its own file if it has changed."""
        changed = {_FILE: self.text} if self.text != before.text else {}
        return Draft(self.root, new, changed, tuple(notes))


def _read(file: Path) -> str:
    text = read_text(file)
    try:
        tomlkit.parse(text)
    except TOMLKitError as error:
        raise FileError(file, f"is no TOML: {error}") from error
    return text


def _package(root: Path) -> str:
    found = [folder.parent.name for folder in sorted((root / "src").glob("*/__init__.py"))]
    if len(found) != 1:
        there = ", ".join(found) or "none"
        raise UsageError(f"{root / 'src'} must have one Python package, with __init__.py; there is {there}")
    return found[0]


def _is_named(requirement: str, name: str) -> bool:
    try:
        own = Requirement(requirement).name
    except InvalidRequirement:
        return False
    return canonical(own) == canonical(name)


@dataclass(frozen=True, slots=True)
class Knowledge:
    """The words and modules available to a package.

    Attributes:
        project: The package.
        ontology: The available words.
        catalogue: The available plug-ins.
    """

    project: Project
    ontology: Ontology
    catalogue: Catalogue

    def condition(self, word: str) -> ConditionType:
        """Returns the condition of that word.

        Raises:
            UnknownName: There is none; the error names the most similar one.
        """
        if word not in self.catalogue.conditions:
            faults = [str(f) for f in self.catalogue.faults if f.group == "skiros.conditions" and f.name == word]
            where = f"({faults[0]})" if faults else ""
            raise UnknownName("condition", word, self.catalogue.conditions, where=where)
        return self.catalogue.conditions[word]

    def read_condition(self, text: str, what: str) -> Condition:
        """Reads ``Scanned(Part)`` or ``not Scanned(Part)``.

        Args:
            text: The text.
            what: Its owner, for messages ("skill 'scan'").

        Raises:
            UsageError: The text has a different form, or too few or too many arguments.
            UnknownName: There is no such condition.
        """
        match = _CONDITION.fullmatch(text.strip())
        if match is None:
            raise UsageError(
                f"condition '{text}': write a word and parameters, such as 'RobotAtLocation(Robot, Station)'"
            )
        try:
            condition = self.condition(match["word"])(*(part.strip() for part in match["arguments"].split(",")))
        except DescriptionError as error:
            raise UsageError(f"{what}, {text}: {error}") from error
        return ~condition if match["not"] else condition

    @staticmethod
    def origin(group: str, name: str) -> Entry:
        """Returns the entry point of a plug-in by its group ("skiros.conditions") and name."""
        return next(entry for entry in installation().of(group) if entry.name == name)

    def primitive(self, name: str) -> tuple[Param, ...]:
        """Returns the parameters of a primitive.

        Raises:
            UnknownName: There is none of that name.
        """
        if name not in self.catalogue.primitives:
            raise UnknownName("primitive", name, list(self.catalogue.primitives))
        return params_of(self.catalogue.primitives[name].Params)

    def check_free(self, kind: str, name: str) -> None:
        """Checks that a name is free for a new skill, primitive or condition.

        Raises:
            UsageError: The name is taken: one of the two would be offered under another.
        """
        if (holder := taken_by(kind, name)) is not None:
            raise UsageError(f"there is {holder} already; choose another name")


def taken_by(kind: str, name: str) -> str | None:
    """Returns the owner of a name of a skill, primitive or condition ("a skill 'pick' of skiros-skills"), or None."""
    groups = ("skiros.conditions",) if kind == "condition" else ("skiros.skills", "skiros.primitives")
    for entry in (entry for group in groups for entry in installation().of(group)):
        if entry.name == name:
            what = entry.group.partition(".")[2].removesuffix("s")
            return f"a {what} '{name}' of {entry.distribution.name}"
    return None


@contextmanager
def knowledge_of(project: Project) -> Iterator[Knowledge]:
    """Loads the knowledge for a package; its own plug-ins are included in their current state, installed or not."""
    with project.as_installed():
        ontology, _ = load_installed(ontology_paths())
        yield Knowledge(project, ontology, load_catalogue())
