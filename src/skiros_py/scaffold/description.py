"""Creates a skill description from the author's options: parameters and conditions, checked and completed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from skiros_py.errors import DescriptionError, UnknownName, UsageError
from skiros_py.scaffold.declared import Declared, Wanted, kind_of, read_parameter, read_wanted
from skiros_py.scaffold.knowledge import Knowledge
from skiros_py.scaffold.primitive import check_keys
from skiros_py.scaffold.spelling import words_of
from skiros_py.skills.conditions import Condition, effects_of
from skiros_py.skills.parameters import Kind
from skiros_py.world.names import local_name

_HAS_PART = "HasPart"
_ROBOT = "Robot"


@dataclass(frozen=True, slots=True)
class NewSkill:
    """The author's options for a skill.

    Attributes:
        name: Its name ("scan").
        help: One sentence; derived from the name if omitted.
        agent: Class of the subsystem that executes it ("sk:Arm"). It adds a parameter for the subsystem and, if the
            condition for it is installed, one for its robot and the condition that it is part of the robot.
        params: Its other parameters (``Part:sk:Manipulatable``).
        pre, post: Conditions over the parameters (``Scanned(Part)``).
        do: Primitives that implement it, in order; none for a skill that is only pretended.
        target: Key of the parameter to which it is applied; if omitted, the first one in a postcondition.
        robot: Name of the robot in its test.
    """

    name: str
    help: str = ""
    agent: str = ""
    params: tuple[str, ...] = ()
    pre: tuple[str, ...] = ()
    post: tuple[str, ...] = ()
    do: tuple[str, ...] = ()
    target: str = ""
    robot: str = "mobile_panda"


@dataclass(frozen=True, slots=True)
class Described:
    """A skill's description: its parameters, the agent first, and its conditions as they are written and meant."""

    agent: str
    target: str
    params: tuple[Declared, ...]
    pre: tuple[tuple[Wanted, Condition], ...]
    post: tuple[tuple[Wanted, Condition], ...]

    @property
    def words(self) -> tuple[str, ...]:
        """The words of its conditions, each once."""
        return tuple(dict.fromkeys(wanted.word for wanted, _ in (*self.pre, *self.post)))


def described(known: Knowledge, said: NewSkill) -> Described:
    """Creates a description from the author's options.

    Raises:
        UsageError: An option is not valid; the text explains what would be.
    """
    own = [read_parameter(text, known.ontology) for text in said.params]
    agent = _agent(known, said, own)
    params = [agent, *(param for param in own if param.key != agent.key)]
    check_keys(own, f"skill '{said.name}'")
    pre, post = ([read_wanted(text) for text in texts] for texts in (said.pre, said.post))
    if not post:
        raise UsageError(f"skill '{said.name}': give a --post, such as 'Scanned(Part)': what it brings about")
    params += _missing_devices(known, said, params)
    params, implied = _with_robot(known, params, [*pre, *post])
    meant = [[(one, _meant(known, said, one, params)) for one in some] for some in ([*implied, *pre], post)]
    for wanted, condition in meant[1]:
        _check_effect(said, wanted, condition)
    return Described(agent.key, _target(said, params, post), tuple(params), tuple(meant[0]), tuple(meant[1]))


def _agent(known: Knowledge, said: NewSkill, own: Sequence[Declared]) -> Declared:
    """Returns the parameter for the executing subsystem: one declared by the author, else a new one."""
    if not said.agent:
        raise UsageError(f"skill '{said.name}': give --agent CLASS, such as sk:Arm: the subsystem that does it")
    class_ = known.ontology.resolve_class(said.agent)
    if not known.ontology.is_a(class_, "sk:Agent"):
        agents = ", ".join(known.ontology.subclasses("sk:Agent"))
        raise UsageError(f"skill '{said.name}': --agent {class_} has no skill manager; there is {agents}")
    key = local_name(class_)
    help_ = f"The {words_of(key)} that does it."
    return next((p for p in own if p.type == class_), Declared(key, class_, help_, Kind.HARDWARE))


def _missing_devices(known: Knowledge, said: NewSkill, params: Sequence[Declared]) -> Iterator[Declared]:
    """Yields parameters for the devices that its primitives need and that are not declared."""
    there = [param.type for param in params if param.is_element]
    for primitive in said.do:
        for param in known.primitive(primitive):
            type_ = param.type
            if param.kind is not Kind.HARDWARE or not isinstance(type_, str):
                continue
            if not any(known.ontology.is_a(own, type_) for own in there):
                there.append(type_)
                key = local_name(type_)
                yield Declared(key, type_, param.help, kind_of(type_, known.ontology))


def _with_robot(
    known: Knowledge, params: Sequence[Declared], wanted: Sequence[Wanted]
) -> tuple[list[Declared], list[Wanted]]:
    """Adds the robot that has the devices, and the relations to them, unless the author specifies the relations."""
    if _HAS_PART not in known.catalogue.conditions:
        return list(params), []
    said = {argument for one in wanted if one.word == _HAS_PART for argument in one.arguments[1:]}
    devices = [p for p in params if p.kind is Kind.HARDWARE and p.key not in said]
    robot = next((p.key for p in params if p.is_element and known.ontology.is_a(p.type, "sk:Robot")), None)
    named = any(_ROBOT in one.arguments for one in wanted)
    if not devices and (robot or not named):
        return list(params), []
    if robot is None:
        robot = _ROBOT
        params = [params[0], Declared(robot, "sk:Robot", "The robot that has it.", Kind.PLANNING), *params[1:]]
    arm = next((p.key for p in params if p.is_element and known.ontology.is_a(p.type, "sk:Arm")), robot)
    whole = {p.key: robot if p.key == arm or _is_body(known, p) else arm for p in devices}
    return list(params), [Wanted(_HAS_PART, (whole[p.key], p.key)) for p in devices]


def _is_body(known: Knowledge, param: Declared) -> bool:
    return any(known.ontology.is_a(param.type, class_) for class_ in ("sk:Base", "sk:Arm"))


def _meant(known: Knowledge, said: NewSkill, wanted: Wanted, params: Sequence[Declared]) -> Condition:
    type_ = known.condition(wanted.word)
    keys = {param.key: param for param in params}
    for argument in wanted.arguments:
        if argument not in keys:
            raise UnknownName("parameter", argument, keys, where=f"in {wanted} of skill '{said.name}'")
    try:
        condition = type_(*wanted.arguments)
    except DescriptionError as error:
        raise UsageError(f"skill '{said.name}', {wanted}: {error}") from error
    for role, argument in zip(type_.roles, wanted.arguments, strict=True):
        _check_role(known, wanted, role.class_, keys[argument])
    return ~condition if wanted.negated else condition


def _check_role(known: Knowledge, wanted: Wanted, class_: str, param: Declared) -> None:
    if not param.is_element or not known.ontology.is_a(param.type, class_):
        raise UsageError(f"{wanted}: {param.key} is a {param.type}; it must be a {class_} there")


def _check_effect(said: NewSkill, wanted: Wanted, condition: Condition) -> None:
    try:
        effects_of(condition)
    except DescriptionError as error:
        raise UsageError(f"skill '{said.name}', --post {wanted}: {error}") from error


def _target(said: NewSkill, params: Sequence[Declared], post: Sequence[Wanted]) -> str:
    keys = [param.key for param in params]
    if said.target:
        if said.target not in keys:
            raise UnknownName("parameter", said.target, keys, where=f"as --target of skill '{said.name}'")
        return said.target
    spoken_of = [argument for one in post for argument in one.arguments]
    things = [param.key for param in params if param.kind is Kind.ONLINE and param.is_element]
    return next((key for key in things if key in spoken_of), (*things, *spoken_of)[0])
