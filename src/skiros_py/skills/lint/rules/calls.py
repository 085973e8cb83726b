"""A body calls modules that are there, with parameters that they have; recursion must be able to end."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from functools import partial

from skiros_py.skills.behaviour import Behaviour, Call, calls_of, walk
from skiros_py.skills.conditions import ConditionType
from skiros_py.skills.lint.rule import Known, Place, Subject, rule
from skiros_py.skills.lint.rules.words import nearest, own_params
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.references import variables
from skiros_py.skills.skill import Skill


@rule("unknown-module", "A body calls an unknown module, or passes it an unknown parameter.", Place, disables=True)
def unknown_module(place: Place, known: Known) -> Iterator[str]:
    """Yields calls of modules that are not there, and arguments that these do not have."""
    for call in place.node.uses().calls:
        if _kind(call, known):
            yield from _wrong_arguments(call, known)
        elif call.module not in known.documents:
            names = sorted({*known.primitives, *(s.description.name for s in known.skills), *known.documents})
            meant = nearest(call.module, names)
            yield f"there is no primitive or skill '{call.module}'{meant}; there is {', '.join(names) or 'none'}"


def _wrong_arguments(call: Call, known: Known) -> Iterator[str]:
    module = f"{_kind(call, known)} '{call.module}'"
    params = {param.key: param for param in known.params(call.module) or ()}
    takes_all = call.module in known.documents and not params
    for key in call.inputs if not takes_all else ():
        if key not in params:
            yield f"{module} has no parameter {key}{nearest(key, params)}"
        elif params[key].kind is Kind.CONFIG:
            yield f"{module} has {key} fixed when it is loaded: it cannot be given at a call"
    outputs = known.outputs(call.module)
    for key in call.outputs:
        if key not in outputs:
            yield f"{module} has no output {key}{nearest(key, outputs)}; it has {', '.join(outputs) or 'none'}"


def _kind(call: Call, known: Known) -> str:
    """Returns what is called; an empty text where nothing is there that can be called now."""
    if call.module in known.primitives:
        return "primitive"
    return "skill" if known.implementations(call.module) else "document" if known.documents.get(call.module) else ""


@rule("not-yet-written", "A node reads a value that only later nodes write.", Place)
def not_yet_written(place: Place, known: Known) -> Iterator[str]:  # noqa: ARG001 - a check's signature
    """Yields values that a node reads before any node can have written them."""
    uses = place.node.uses()
    read = [*uses.names, *((name, str(c)) for c in uses.conditions for name in (*c.arguments, *c.names))]
    for name, asker in dict.fromkeys(read):
        if name in place.later and name not in {*place.written, *place.values, *place.classes}:
            yield f"{asker} reads '{name}', which only a later node writes"


@rule("missing-argument", "A call omits an argument that cannot be inferred.", Place, disables=True)
def missing_argument(place: Place, known: Known) -> Iterator[str]:
    """Yields required parameters that a call does not give and a run cannot fill in."""
    for call in place.node.uses().calls:
        kind, params = _kind(call, known), known.params(call.module) or ()
        if not {param.key for param in params}.issuperset(call.inputs):
            continue  # the name of an argument is wrong: another rule says so
        for param in params:
            if param.kind.is_required and param.key not in call.arguments and not _is_filled_in(param, kind):
                yield f"{kind} '{call.module}' needs {param.key}"


def _is_filled_in(param: Param, kind: str) -> bool:
    """Tells whether a run finds it: what it can of a skill, and of a primitive what belongs to the robot."""
    return param.is_inferred and (kind == "skill" or param.kind in (Kind.HARDWARE, Kind.PLANNING))


@rule(
    "missing-parameter", "A reference to a parameter that does not exist.", Skill, ConditionType, type,
    disables=True,
)  # fmt: skip
def missing_parameter(subject: Subject, known: Known) -> Iterator[str]:  # noqa: ARG001 - a check's signature
    """Yields references to what is not there; those in bodies were checked when the skill was made."""
    match subject:
        case Skill():
            posts = [condition.key for condition in subject.description.post]
            asserted = (node.uses().pretends or () for root in subject.nodes for node in walk(root))
            for key in (key for keys in asserted for key in keys if key not in posts):
                yield f"it asserts '{key}', which is not a postcondition; there is {', '.join(posts)}"
        case ConditionType():
            strays = sorted(set(variables(subject.pattern)) - {role.name for role in subject.roles})
            yield from (f"its pattern asks for {name}, which is no role" for name in strays)
        case _:
            keys = [param.key for param in own_params(subject)]
            for key in (key for key in getattr(subject, "takes", ()) if key not in keys):
                yield f"it takes {key}, which is not one of its parameters{nearest(key, keys)}"


@rule("recursive-skill", "A skill that calls itself endlessly.", Skill)
def recursive_skill(skill: Skill, known: Known) -> Iterator[str]:
    """Yields a problem for an implementation none of whose ways to succeed ever ends."""
    endless = endless_modules(known, [s for s in known.skills if s.driver == skill.driver])
    if not _all_can_end(skill.nodes, endless):
        calls = sorted({call.module for call in calls_of(*skill.nodes)} & endless)
        yield f"every way to succeed calls {' and '.join(calls)}, which leads back to this skill"


def endless_modules(known: Known, skills: Collection[Skill]) -> set[str]:
    """Returns the modules whose calls lead back to themselves, and what calls these.

    A skill counts if each of its ways to succeed does; a document if one of its calls does, whatever lies between:
    it repeats by ``repeat`` and ``retry``.

    Args:
        known: The documents.
        skills: The skills.
    """
    ends: list[tuple[str, Callable[[Collection[str]], bool]]] = [
        (skill.description.name, partial(_all_can_end, skill.nodes)) for skill in skills
    ]
    for name, document in known.documents.items():
        if document:
            ends.append((name, {call.module for call in calls_of(document.behaviour)}.isdisjoint))
    endless = {name for name, _ in ends}
    while ending := endless & {name for name, can_end in ends if can_end(endless)}:
        endless -= ending
    return endless


def _all_can_end(nodes: Collection[Behaviour], open_: Collection[str]) -> bool:
    return all(_can_end(node, open_) for node in nodes)


def _can_end(node: Behaviour, open_: Collection[str]) -> bool:
    uses = node.uses()
    if any(call.module in open_ for call in uses.calls):
        return False
    children = (_can_end(child, open_) for child in node.named_children().values())
    match uses.needs:
        case "any":
            return any(children)
        case "all":
            return all(children)
        case "none":
            return True
