"""The words and modules available to a package being written: installed ones, and its own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from skiros_py.catalogue import Catalogue, load_catalogue
from skiros_py.config import ontology_paths
from skiros_py.errors import UnknownName, UsageError
from skiros_py.plugins import installation
from skiros_py.scaffold.project import Project
from skiros_py.skills.conditions import ConditionType
from skiros_py.skills.parameters import Param, params_of
from skiros_py.world.ontology import Ontology, load_installed


@dataclass(frozen=True, slots=True)
class Origin:
    """Where an object of a plug-in is imported from.

    Attributes:
        module: Its module.
        name: Its name there.
        distribution: Name of the distribution that provides it.
    """

    module: str
    name: str
    distribution: str


class Knowledge:
    """The words and modules available to a package.

    Attributes:
        project: The package.
        ontology: The available words.
        catalogue: The available plug-ins.
    """

    def __init__(self, project: Project, ontology: Ontology, catalogue: Catalogue) -> None:
        self.project = project
        self.ontology = ontology
        self.catalogue = catalogue

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

    def origin(self, word: str) -> Origin:
        """Returns where the condition of that word is imported from."""
        return _origin("skiros.conditions", word)

    def primitive_origin(self, name: str) -> Origin:
        """Returns where the primitive of that name is imported from."""
        return _origin("skiros.primitives", name)

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
            UsageError: The name is taken: neither of the two could be used.
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


def _origin(group: str, name: str) -> Origin:
    entry = next(entry for entry in installation().of(group) if entry.name == name)
    return Origin(entry.module, entry.attribute, entry.distribution.name)


@contextmanager
def knowledge_of(project: Project) -> Iterator[Knowledge]:
    """Loads the knowledge for a package; its own plug-ins are included in their present state, installed or not."""
    with project.as_installed():
        ontology, _ = load_installed(ontology_paths())
        yield Knowledge(project, ontology, load_catalogue())
