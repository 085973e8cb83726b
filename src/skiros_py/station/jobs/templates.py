"""Goal templates (ISA-95: work masters): stored beside the world, checked when written, and filled in by orders."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

from skiros_py.api.goals import Material
from skiros_py.api.templates import GoalTemplate, GoalTemplateContent
from skiros_py.errors import UnknownName, UsageError
from skiros_py.skills.conditions import ConditionType
from skiros_py.station.documents import TEMPLATE, Document, DocumentStore
from skiros_py.station.jobs.filling import faults_of, filled
from skiros_py.station.jobs.texts import check_structure, goal_texts
from skiros_py.world.names import local_name
from skiros_py.world.ontology import Ontology

KIND = TEMPLATE


class TemplateStore:
    """The goal templates of a data directory.

    Args:
        documents: The store that contains them.
    """

    def __init__(self, documents: DocumentStore) -> None:
        self._documents = documents

    def all(self) -> tuple[GoalTemplate, ...]:
        """Returns all templates, by name."""
        return tuple(_template(document) for document in self._documents.all(KIND))

    def get(self, name: str) -> GoalTemplate | None:
        """Returns a template; None if there is none."""
        document = self._documents.get(KIND, name)
        return None if document is None else _template(document)

    def find(self, name: str) -> GoalTemplate:
        """Returns a template.

        Raises:
            UnknownName: There is none.
        """
        return _template(self._documents.find(KIND, name))

    def put(self, name: str, content: GoalTemplateContent, *, expects: int | None) -> GoalTemplate:
        """Writes a template.

        Args:
            name: Its name.
            content: Its content; see :func:`check_template`.
            expects: The version that it replaces; 0 if there must be none yet; None for any.

        Raises:
            StaleVersion: The present version is a different one.
        """
        data = content.model_dump(mode="json", by_alias=True)
        return _template(self._documents.put(KIND, name, data, expects=expects))

    def remove(self, name: str, *, expects: int | None) -> None:
        """Removes a template.

        Raises:
            StaleVersion: The present version is a different one.
        """
        self._documents.remove(KIND, name, expects=expects)

    def texts(self, name: str, parameters: Mapping[str, str], materials: tuple[Material, ...]) -> tuple[str, ...]:
        """Returns the goal texts of a template filled in with an order.

        Raises:
            UnknownName: There is no such template, or it has no such parameter.
            UsageError: A parameter is missing, or the material does not fit.
        """
        content = self.find(name).content
        return goal_texts(filled(name, content, parameters, materials))


def check_template(content: GoalTemplateContent, ontology: Ontology, conditions: Mapping[str, ConditionType]) -> None:
    """Checks that a template can produce goals: its structure, placeholders, words and classes.

    Raises:
        UsageError: It is not valid; the text lists all faults, each with its path.
    """
    faults = faults_of(content) or [*_class_faults(content, ontology), *_word_faults(content, conditions)]
    if faults:
        raise UsageError("; ".join(faults[:20]))


def _class_faults(content: GoalTemplateContent, ontology: Ontology) -> Iterator[str]:
    classes: dict[str, str] = {name: name for curie in ontology.classes for name in (curie, local_name(curie))}
    for index, parameter in enumerate(content.parameters):
        if parameter.class_ and parameter.class_ not in classes:
            yield f"parameters[{index}].class: {UnknownName('class', parameter.class_, classes)}"


def _word_faults(content: GoalTemplateContent, conditions: Mapping[str, ConditionType]) -> Iterator[str]:
    """Fills in the template with placeholder names, and yields the faults of the result."""
    stand_in = {parameter.name: "x" for parameter in content.parameters}
    material = Material.model_validate({"class": "x", "id": "x", "location": "x", "use": "x"})
    try:
        goals = filled("it", content, stand_in, (material,) if content.per_material is not None else ())
    except UsageError as error:
        yield str(error)
        return
    paths = [*(f"goal[{index}]" for index in range(len(content.goal))), "per_material"]
    for path, goal in zip(paths, goals, strict=False):
        try:
            check_structure(goal, path)
        except UsageError as error:
            yield str(error)
            continue
        yield from _unknown_words(goal, path, conditions)


def _unknown_words(data: object, path: str, conditions: Mapping[str, ConditionType]) -> Iterator[str]:
    known = {name.casefold(): type_ for name, type_ in conditions.items()}
    match data:
        case {"condition": str(word), "arguments": list(arguments)}:
            yield from _word_fault(word, arguments, path, known, conditions)
        case dict():
            for key, value in data.items():
                yield from _unknown_words(value, f"{path}.{key}", conditions)
        case list():
            for index, value in enumerate(data):
                yield from _unknown_words(value, f"{path}[{index}]", conditions)


def _word_fault(
    word: str, arguments: Collection[object], path: str, known: Mapping[str, ConditionType], all_: Collection[str]
) -> Iterator[str]:
    type_ = known.get(word.casefold())
    if type_ is None:
        yield f"{path}.condition: {UnknownName('condition', word, all_)}"
    elif len(arguments) != len(type_.roles):
        roles = ", ".join(f"{role.name}: {local_name(role.class_)}" for role in type_.roles)
        yield f"{path}.arguments: {type_.name} takes {len(type_.roles)} ({roles}), got {len(arguments)}"


def _template(document: Document) -> GoalTemplate:
    content = GoalTemplateContent.model_validate(document.data)
    return GoalTemplate(name=document.name, version=document.version, content=content)
