"""Goal templates (ISA-95: work masters): documents that orders fill in; goals as texts."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any, ClassVar

from pydantic import ValidationError

from skiros_py.api.goals import GoalTemplateContent, Material
from skiros_py.api.wire import fault_words
from skiros_py.behaviours import DocumentKind, PaletteEntry, Review
from skiros_py.errors import DocumentError, DocumentFault, UnknownName, UsageError
from skiros_py.messages import Message
from skiros_py.skills.conditions import ConditionType
from skiros_py.skills.plain import Reader
from skiros_py.skills.skill import SkillDescription
from skiros_py.station.document_store import TEMPLATE
from skiros_py.tasks.goals import forms
from skiros_py.tasks.goals.forms import Form
from skiros_py.tasks.goals.parsing import Meaning
from skiros_py.world.names import local_name
from skiros_py.world.ontology import Ontology
from skiros_py.world.view import WorldView

_DEEPEST = 60
"""Maximum nesting: the goal language refuses deeper goals anyway, and recursion over them would fail."""
_VARIABLE = re.compile(r"[^\W\d]\w*")


def goal_texts(goal: object) -> tuple[str, ...]:
    """Returns the texts of a goal: texts unchanged, structured conditions converted.

    Args:
        goal: A text, a structured condition, or several of either.

    Raises:
        UsageError: The structure is wrong; the text gives the path to the fault.
    """
    several = goal if isinstance(goal, list | tuple) else [goal]
    structured = iter(_forms([one for one in several if not isinstance(one, str)], "goal", alone=several is not goal))
    return tuple(one if isinstance(one, str) else _text(next(structured), frozenset(), 0) for one in several)


def check_structure(data: dict[str, Any], where: str) -> None:
    """Requires that a structured condition can be converted into text.

    Args:
        data: The condition.
        where: Path to it.

    Raises:
        DocumentError: It cannot.
    """
    (form,) = _forms([data], where, alone=True)
    try:
        _text(form, frozenset(), 0)
    except UsageError as error:
        raise DocumentError([DocumentFault(where, str(error))]) from None


def _forms(data: Sequence[object], where: str, *, alone: bool) -> list[Form]:
    try:
        return forms.FORMS.validate_python(list(data))
    except ValidationError as error:
        raise DocumentError(_pydantic_faults(where, error, skip=int(alone))) from None


def _pydantic_faults(where: str, error: ValidationError, *, skip: int) -> list[DocumentFault]:
    faults = error.errors(include_url=False)[:20]
    paths = [f"{where}{forms.field_path(one['loc'][skip:])[:200]}" for one in faults]
    return [DocumentFault(path.lstrip("."), fault_words(one)) for path, one in zip(paths, faults, strict=True)]


def _text(form: Form, variables: frozenset[str], depth: int) -> str:
    """Returns the text of a condition; everything joined or negated is in parentheses."""
    if depth > _DEEPEST:
        raise UsageError(
            "the goal is nested deeper than {levels} levels: say it in several conditions", levels=_DEEPEST
        )
    match form:
        case forms.Word(condition=word, arguments=arguments):
            return f"{_word(word)}({', '.join(_name(argument.text, variables) for argument in arguments)})"
        case forms.Negation(part=part):
            return f"not ({_text(part, variables, depth + 1)})"
        case forms.AllOf(parts=parts) | forms.AnyOf(parts=parts):
            return f" {form.word} ".join(f"({_text(part, variables, depth + 1)})" for part in parts)
        case forms.Implication(premise=premise, then=then):
            return f"({_text(premise, variables, depth + 1)}) implies ({_text(then, variables, depth + 1)})"
        case forms.ForAll(variable=variable, holds=holds) | forms.Exists(variable=variable, holds=holds):
            if not _VARIABLE.fullmatch(variable):
                raise UsageError("'{name}' cannot be a variable: letters, digits and _ only", name=variable[:100])
            inner = _text(holds, variables | {variable}, depth + 1)
            return f"{form.quantifier} {variable}: {_name(form.class_)} ({inner})"


def _word(word: str) -> str:
    if not forms.PLAIN.fullmatch(word):
        raise UsageError(
            "unknown condition '{name}' in the goal: a word consists of letters, digits and _", name=word[:100]
        )
    return word


def _name(name: str, variables: frozenset[str] = frozenset()) -> str:
    if not name:
        raise UsageError(Message("a name in the goal is empty"))
    return name if name in variables else forms.quoted(name)


_FIELDS = ("class", "definition", "id", "location", "lot", "use")
"""The fields of a material that a placeholder may refer to."""
_MOST = 2000
"""Maximum number of conditions that a template may produce."""
_LARGEST = 5000
"""Maximum total number of names, lists and objects in a template."""
_MOST_MADE = 20_000
"""The same for the result of filling it in."""


def filled(
    name: str, template: GoalTemplateContent, parameters: Mapping[str, str], materials: Sequence[Material]
) -> list[Any]:
    """Returns the structured conditions of a template filled in with an order.

    Args:
        name: Its name, for messages.
        template: Its content.
        parameters: The parameters of the order, by name.
        materials: The materials of the order.

    Raises:
        UnknownName: The template has no such parameter.
        UsageError: A parameter is missing, or the material does not fit.
    """
    values = _values(name, template, parameters)
    goal = [_replaced(one, values, {}) for one in template.goal]
    if template.per_material is None:
        if materials:
            raise UsageError("materials: goal template '{name}' says nothing of materials; leave them out", name=name)
        return goal
    _check_number(name, template.per_material, materials)
    pieces = [_replaced(template.per_material, values, piece) for piece in _pieces(materials)]
    _check_pieces(name, pieces)
    return goal + pieces


def faults_of(template: GoalTemplateContent) -> list[DocumentFault]:
    """Returns the faults in the placeholders of a template."""
    size = _size([*template.goal, template.per_material])
    if size > _LARGEST:
        return [
            DocumentFault(
                "goal", Message("at most {most} names, lists and objects, not {count}", most=_LARGEST, count=size)
            )
        ]
    names = [parameter.name for parameter in template.parameters]
    twice = sorted({name for name in names if names.count(name) > 1})
    faults = [DocumentFault("parameters", Message("'{name}' is there twice", name=name)) for name in twice]
    for index, goal in enumerate(template.goal):
        faults += _faults(goal, f"goal[{index}]", names, ())
    if template.per_material is not None:
        faults += _faults(template.per_material, "per_material", names, _FIELDS)
    if not template.goal and template.per_material is None:
        faults.append(DocumentFault("goal", Message("a template needs conditions, or one for each material")))
    return faults


def _values(name: str, template: GoalTemplateContent, parameters: Mapping[str, str]) -> dict[str, str]:
    known = {parameter.name: parameter.default for parameter in template.parameters}
    for given in parameters:
        if given not in known:
            raise UnknownName("parameter", given, known, where=f"of goal template '{name}'")
    values = {key: parameters.get(key, default) for key, default in known.items()}
    missing = [key for key, value in values.items() if value is None]
    if missing:
        raise UsageError("parameters: goal template '{name}' needs {things}", name=name, things=", ".join(missing))
    return {key: value for key, value in values.items() if value is not None}


def _pieces(materials: Sequence[Material]) -> Iterator[dict[str, str]]:
    """Yields each single piece of the order."""
    for material in materials:
        fields = material.model_dump(by_alias=True)
        for _ in range(material.pieces):
            yield {field: fields[field] for field in _FIELDS}


def _check_number(name: str, condition: object, materials: Sequence[Material]) -> None:
    """Checks that the material does not produce too many conditions, before producing any."""
    number = sum(material.pieces for material in materials)
    if number > _MOST:
        raise UsageError("materials: more than {most} pieces in one order", most=_MOST)
    if number * _size(condition) > _MOST_MADE:
        raise UsageError(
            f"materials: goal template '{name}' is too large for {number} pieces in one order; for"
            f" {_MOST_MADE // _size(condition)} it will do"
        )


def _walk(data: object, path: str = "") -> Iterator[tuple[str, Any, int]]:
    """Yields data and all parts of it, in order, each with its path and depth; without recursion, for any depth."""
    waiting = [(path, data, 0)]
    while waiting:
        path, one, depth = waiting.pop()
        yield path, one, depth
        if isinstance(one, dict):
            inner = [(f"{path}.{key}", value, depth + 1) for key, value in one.items()]
        else:
            parts = one if isinstance(one, list | tuple) else ()
            inner = [(f"{path}[{index}]", value, depth + 1) for index, value in enumerate(parts)]
        waiting += reversed(inner)


def _size(data: object) -> int:
    """Returns the number of names, lists and objects in the data."""
    return sum(1 for _ in _walk(data))


def _check_pieces(name: str, pieces: list[Any]) -> None:
    """Checks that each piece has its own condition: two identical ones would be fulfilled by one piece."""
    if not pieces:
        raise UsageError(
            "materials: goal template '{name}' makes a condition of each material, and none is ordered", name=name
        )
    seen = set()
    for piece in pieces:
        # "Starter" and "kitting:Starter" are the same class.
        content = tuple((path, one.rpartition(":")[2]) for path, one, _ in _walk(piece) if isinstance(one, str))
        if content in seen:
            raise UsageError(
                f"materials: two pieces lead to the same condition {piece!r:.200}, which one of them would fulfil:"
                " give each an id or a location of its own, and a template that uses it"
            )
        seen.add(content)


def _replaced(data: Any, parameters: Mapping[str, str], material: Mapping[str, str]) -> Any:
    """Returns data with placeholders replaced by names."""
    match data:
        case {"parameter": str(key)} if len(data) == 1:
            return parameters[key]
        case {"material": str(field)} if len(data) == 1:
            if not material[field]:
                raise UsageError("materials: the goal template needs the {field} of each material", field=field)
            return material[field]
        case dict():
            return {key: _replaced(value, parameters, material) for key, value in data.items()}
        case list():
            return [_replaced(value, parameters, material) for value in data]
        case _:
            return data


def _faults(data: object, where: str, names: Sequence[str], fields: Sequence[str]) -> Iterator[DocumentFault]:
    for path, one, depth in _walk(data, where):
        match one:
            case _ if depth > _DEEPEST:
                yield DocumentFault(path[:200], Message("nested deeper than {levels} levels", levels=_DEEPEST))
                return
            case {"parameter": key} if len(one) == 1 and key not in names:
                yield DocumentFault(path, str(UnknownName("parameter", str(key), names)))
            case {"material": field} if len(one) == 1 and field not in fields:
                unless = "" if fields else "(materials are for per_material only)"
                yield DocumentFault(path, str(UnknownName("field of a material", str(field), fields, where=unless)))


def content_of(document: Any) -> GoalTemplateContent:
    """Returns the content of a template.

    Raises:
        DocumentError: It is no template; each fault has its place.
    """
    try:
        return GoalTemplateContent.model_validate(document)
    except ValidationError as error:
        raise DocumentError(_pydantic_faults("", error, skip=0)) from None


class TemplateDocument(DocumentKind):
    """A goal with placeholders, which orders fill in (ISA-95: work master)."""

    kind: ClassVar[str] = TEMPLATE
    for_orders: ClassVar[bool] = True

    def check(self, document: Any, reader: Reader) -> tuple[DocumentFault, ...]:
        """Returns the faults in its structure, its placeholders and the words of its goals."""
        try:
            content = content_of(document)
        except DocumentError as error:
            return error.faults
        return tuple(faults_of(content) or _word_faults(content, reader.words))

    def review(
        self,
        document: Any,
        world: WorldView,
        skills: Mapping[str, SkillDescription],  # noqa: ARG002
        conditions: Mapping[str, ConditionType],
    ) -> Review:
        """Checks the classes of its parameters, and its conditions as those of goals; missing elements are problems."""
        content = content_of(document)
        if faults := tuple(_class_faults(content, world.ontology)):
            return Review(faults)
        found = tuple(_argument_faults(content, world, conditions))
        return Review(
            tuple(fault for fault, error in found if not isinstance(error, UnknownName)),
            tuple(fault for fault, error in found if isinstance(error, UnknownName)),
        )

    def palette(self, reader: Reader) -> Sequence[PaletteEntry]:  # noqa: ARG002
        """Returns nothing: a template has no nodes."""
        return ()


def _class_faults(content: GoalTemplateContent, ontology: Ontology) -> Iterator[DocumentFault]:
    classes: dict[str, str] = {name: name for curie in ontology.classes for name in (curie, local_name(curie))}
    for index, parameter in enumerate(content.parameters):
        if parameter.class_ and parameter.class_ not in classes:
            yield DocumentFault(f"parameters[{index}].class", str(UnknownName("class", parameter.class_, classes)))


def _argument_faults(
    content: GoalTemplateContent, world: WorldView, conditions: Mapping[str, ConditionType]
) -> Iterator[tuple[DocumentFault, UsageError]]:
    """Yields what is wrong with the arguments of conditions, where each placeholder is any element of its class."""
    meaning = Meaning(world, conditions)
    scope = {_stand_in("parameter", one.name): one.class_ for one in content.parameters}
    scope = {name: class_ and world.ontology.resolve_class(class_) for name, class_ in scope.items()}
    scope |= {_stand_in("material", field): "" for field in _FIELDS}
    for path, goal in _stood_in(content):
        if any(isinstance(one, dict) and one.get("class") in scope for _, one, _ in _walk(goal)):
            continue  # the order gives the class of a quantifier
        (form,) = _forms([goal], path, alone=True)
        try:
            meaning.of(form, scope)
        except UsageError as error:
            yield DocumentFault(path, str(error)), error


def _stand_in(kind: str, name: str) -> str:
    """Returns what stands for a placeholder, for checks and messages."""
    return f"{kind} {name}"


def _stood_in(content: GoalTemplateContent) -> Iterator[tuple[str, Any]]:
    """Yields the conditions of a template filled in with names for its placeholders, with their places.

    Raises:
        UsageError: It cannot be filled in.
    """
    values = {parameter.name: _stand_in("parameter", parameter.name) for parameter in content.parameters}
    material = Material.model_validate({field: _stand_in("material", field) for field in _FIELDS})
    goals = filled("it", content, values, (material,) if content.per_material is not None else ())
    paths = [*(f"goal[{index}]" for index in range(len(content.goal))), "per_material"]
    yield from zip(paths, goals, strict=False)


def _word_faults(content: GoalTemplateContent, conditions: Mapping[str, ConditionType]) -> Iterator[DocumentFault]:
    """Yields the faults of its structure and words."""
    try:
        goals = tuple(_stood_in(content))
    except UsageError as error:
        yield DocumentFault("", str(error))
        return
    for path, goal in goals:
        try:
            check_structure(goal, path)
        except DocumentError as error:
            yield from error.faults
            continue
        for place, one, _ in _walk(goal, path):
            match one:
                case {"condition": str(word), "arguments": list(arguments)}:
                    yield from _word_fault(word, arguments, place, conditions)


def _word_fault(
    word: str, arguments: Collection[object], path: str, conditions: Mapping[str, ConditionType]
) -> Iterator[DocumentFault]:
    type_ = next((type_ for name, type_ in conditions.items() if name.casefold() == word.casefold()), None)
    if type_ is None:
        yield DocumentFault(f"{path}.condition", str(UnknownName("condition", word, conditions)))
    elif len(arguments) != len(type_.roles):
        roles = ", ".join(f"{role.name}: {local_name(role.class_)}" for role in type_.roles)
        text = f"{type_.name} takes {len(type_.roles)} ({roles}), got {len(arguments)}"
        yield DocumentFault(f"{path}.arguments", text)
