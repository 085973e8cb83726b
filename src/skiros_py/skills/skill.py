"""Skills: a description (what it needs and what it brings about) and the implementations that do it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from typing import Any

from skiros_py.errors import DescriptionError, UnknownName
from skiros_py.messages import Message
from skiros_py.skills.behaviour import Behaviour, check_behaviour, check_nodes, walk
from skiros_py.skills.conditions import (
    Computed,
    Condition,
    ConditionType,
    Has,
    Pattern,
    Related,
    Role,
    Verdict,
    all_of,
    any_of,
)
from skiros_py.skills.conditions.expression import is_sensed
from skiros_py.skills.conditions.pattern import NumberChange, leaves
from skiros_py.skills.parameters import IT, Kind, Param, check_params
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.references import check_references, variables
from skiros_py.skills.surroundings import robot_of
from skiros_py.world.terms import reached
from skiros_py.world.view import WorldView, wholes
from skiros_py.world.vocabulary import HAS_A


def nearest_first(param: Param, agent: str) -> Param:
    """Returns a device's parameter that prefers what the agent itself is built of, where its author prefers nothing."""
    if param.kind is not Kind.HARDWARE or param.preferred or param.cost is not None or param.key == agent:
        return param
    return replace(param, prefer=Computed("sk:hasPiece", agent, IT, _is_piece))


def _together(key: str, said: Iterable[Condition]) -> set[str]:
    """What the conditions say to be of one whole with something, over any number of steps."""
    patterns = (condition.pattern for condition in said)
    links = [{p.subject, p.object} for p in patterns if isinstance(p, Related) and p.relation == HAS_A]
    return set(reached([key], lambda end: (other for link in links if end in link for other in link)))


def _of_one_robot(agent: Param, device: Param) -> Condition:
    roles = (Role("agent", agent.element_class), Role("device", device.element_class))
    pattern = Computed("sk:ofOneRobot", "agent", "device", _is_on_robot)
    word = ConditionType("OfOneRobot", roles, pattern, "The device is of the subsystem's own robot.")
    return word(agent.key, device.key)


def _is_on_robot(view: WorldView, agent: str, device: str) -> Verdict:
    return _is_piece(view, robot_of(view, agent), device)


def _is_piece(view: WorldView, whole: str, piece: str) -> Verdict:
    holds = whole in wholes(view, piece)
    said = {"piece": piece, "whole": whole}
    if holds:
        return Verdict(True, Message("{piece} is a piece of {whole}", **said))
    return Verdict(False, Message("{piece} is no piece of {whole}", **said))


@dataclass(frozen=True, slots=True)
class SkillDescription:
    """What a skill means, apart from how it is done (paper Fig. 9). Authors write domain words, never PDDL.

    Attributes:
        name: Its name ("pick").
        help: One sentence for people.
        agent: Key of the parameter that is the subsystem doing it; its class tells which skill managers take it.
        params: Parameters; each element parameter has a class.
        pre: Must hold before it starts.
        hold: Must hold while it runs.
        post: Hold after it; asserted by the primitives that sensed them, then checked.
        target: Key of the parameter it is done to or for; when the skill keeps failing, this element is left out of
            further plans.
        duration: How long it takes as a rule [s]; what robots learn from their runs counts before it. None where the
            author does not know.
        limit: How long one attempt may take at most [s], without pauses and questions to a person; ``math.inf`` for no
            limit. None for 20 times the duration, at least 300 s; no limit where that is not known either.
        refines: Name of the description that it was refined from (:meth:`refined`); empty for none.
    """

    name: str
    help: str
    agent: str
    target: str
    params: tuple[Param, ...]
    pre: tuple[Condition, ...] = ()
    hold: tuple[Condition, ...] = ()
    post: tuple[Condition, ...] = ()
    duration: float | None = None
    limit: float | None = None
    refines: str = ""

    def __post_init__(self) -> None:
        name: object = self.name
        if not isinstance(name, str) or not name or ":" in name:
            raise DescriptionError(f"skill name {name!r}: it must be a text, not empty, and without ':'")
        for part in ("params", "pre", "hold", "post"):
            if not isinstance(given := getattr(self, part), tuple):
                raise DescriptionError(f"{part} of skill '{name}': it must be a tuple, not a {type(given).__name__}")
        check_params(self.params, f"of skill '{self.name}'")
        for condition in (*self.pre, *self.hold, *self.post):
            stated: object = condition
            if not isinstance(stated, Condition):
                said = getattr(stated, "name", repr(stated))
                raise DescriptionError(f"{said} of skill '{name}': it must be a condition of parameters: {said}('…')")
            self._check_elements(condition.arguments, f"in {condition} of skill '{self.name}'")
        self._check_elements((self.agent, self.target), f"as agent or target of skill '{self.name}'")
        for part in ("hold", "post"):
            conditions: tuple[Condition, ...] = getattr(self, part)
            if both := next((c for c in conditions if not c.negated and ~c in conditions), None):
                raise DescriptionError(f"{part} of skill '{self.name}': {both} and {~both} can never hold together")
        if not self.post:
            right = "say what it brings about by post=(…,)"
            raise DescriptionError(f"skill '{self.name}' has no postcondition: no goal could ever need it; {right}")
        if self.duration is not None and not 0.0 < self.duration < inf:
            raise DescriptionError(f"duration of skill '{self.name}': {self.duration:g}; it must be some seconds")
        if self.limit is not None and not self.limit > 0.0:
            raise DescriptionError(f"limit of skill '{self.name}': {self.limit:g}; it must be some seconds, or inf")

    def _check_elements(self, keys: Iterable[str], where: str) -> None:
        params = {param.key: param for param in self.params}
        for key in keys:
            if key not in params:
                raise UnknownName("parameter", key, params, where=where)
            if not params[key].is_element:
                raise DescriptionError(
                    f"parameter {key} {where}: it must be an element, and it is a {params[key].type_name}"
                )

    def refined(
        self,
        name: str,
        agent_class: str,
        *,
        help: str,  # noqa: A002 - as the field is called
        pre: Sequence[Condition] = (),
        hold: Sequence[Condition] = (),
        post: Sequence[Condition] = (),
    ) -> SkillDescription:
        """Returns the same description for some of its agents, of whom more is asked: they have it instead of this one.

        The ontology says of their class that they never have this one: ``sk:refinedSkills "drive"``.

        Args:
            name: Its name ("drive_by_air").
            agent_class: Class of its agents, below the one of this description.
            help: One sentence for people.
            pre: What must hold, too, before it starts.
            hold: What must hold, too, while it runs.
            post: What holds after it, too.
        """
        params = (replace(one, type=agent_class) if one.key == self.agent else one for one in self.params)
        return replace(
            self,
            name=name,
            help=help,
            params=tuple(params),
            pre=(*self.pre, *pre),
            hold=(*self.hold, *hold),
            post=(*self.post, *post),
            refines=self.name,
        )

    def param(self, key: str) -> Param:
        """Returns the parameter of that key.

        Raises:
            UnknownName: There is none.
        """
        for candidate in self.params:
            if candidate.key == key:
                return candidate
        raise UnknownName("parameter", key, [p.key for p in self.params], where=f"of skill '{self.name}'")

    @property
    def agent_class(self) -> str:
        """Class of the subsystem that can do it."""
        return self.param(self.agent).element_class

    @property
    def needs(self) -> tuple[Condition, ...]:
        """What must hold before it starts.

        Its devices are of one robot, the numbers that it changes are there, its parameters are as described; and its
        preconditions.
        """
        said = (*self.described, *self.pre)
        together, agent = _together(self.agent, said), self.param(self.agent)
        apart = (p for p in self.params if p.kind is Kind.HARDWARE and p.key not in together)
        return (*(_of_one_robot(agent, param) for param in apart), *self.counted, *said)

    @property
    def counted(self) -> tuple[Condition, ...]:
        """The numbers that its effects raise and lower."""
        changes = (leaf for condition in self.post for leaf, _ in leaves(condition.pattern))
        asked = dict.fromkeys(pair for one in changes if isinstance(one, NumberChange) for pair in one.counted)
        return tuple(self._number(key, name) for key, name in asked)

    def _number(self, key: str, name: str) -> Condition:
        roles, pattern = (Role("of", self.param(key).element_class),), Has(name, "of")
        return ConditionType("HasNumber", roles, pattern, "What is to be changed is there.")(key)

    @property
    def described(self) -> tuple[Condition, ...]:
        """What its parameters are described as (:attr:`Param.where`)."""
        return tuple(self._described(param, pattern) for param in self.params for pattern in param.described)

    def under(self, alternatives: Iterable[Sequence[Condition]]) -> SkillDescription:
        """Returns the description for those who count on it: all conditions of one of the alternatives must hold, too.

        What is sensed or speaks of optional parameters is left out: it is not known before.

        Args:
            alternatives: What each of the implementations asks for besides (:attr:`Skill.when`).
        """
        known = dict.fromkeys(tuple(filter(self._is_known_before, conditions)) for conditions in alternatives)
        if () in known or not known:
            return self
        ways = [all_of(*conditions) if len(conditions) > 1 else conditions[0] for conditions in known]
        return replace(self, pre=(*self.pre, ways[0] if len(ways) == 1 else any_of(*ways)))

    def _is_known_before(self, condition: Condition) -> bool:
        kinds = (self.param(key).kind for key in condition.arguments)
        return not is_sensed(condition.pattern) and all(kind.is_required or kind.has_default for kind in kinds)

    def _described(self, param: Param, pattern: Pattern) -> Condition:
        own = pattern.rename({IT: param.key})
        roles = tuple(Role(key, self.param(key).element_class) for key in variables(own))
        word = ConditionType(f"{param.key}AsDescribed", roles, own, f"What {param.key} must be: {param.help}")
        return word(*(role.name for role in roles))


@dataclass(frozen=True, slots=True)
class Skill:
    """One way to do what a description promises: pure data, so it can be printed, drawn, exported and run.

    Several implementations may share a description. Those that the robot has the means for are tried in their order,
    the next one when one cannot be started or fails.

    Order of a run: pre-sensing, preconditions, body, finish, post-sensing, postconditions (paper Fig. 9).

    Attributes:
        description: What it promises.
        body: What is done between the checks of pre- and postconditions.
        pre_sense: Sensing before the preconditions are checked, or None.
        post_sense: Sensing before the postconditions are checked, or None.
        finish: Done after the body whether it worked or not (stow the arm), also when the skill is cancelled for
            another plan; not when everything is stopped.
        driver: Kind of cell driver it is for ("fake"), or None for every driver that is not a fake.
        version: Version of this implementation.
        label: Its name among the implementations of the description.
        requires: Classes of devices that the robot must have for it.
        when: Further conditions, over the parameters, under which this implementation can be used.
        order: Implementations are tried by this number, then by label.
        takes: Keys of further parameters, besides those of kind HARDWARE, whose element is taken with all devices it
            has: no other module commands them meanwhile. A location (a kit) is taken itself: one at a time works there.
        primitives: Primitives that come with it, and so need no entry points.
        source: File and line where it is written, for messages; an empty file where that is not known.
    """

    description: SkillDescription
    body: Behaviour
    pre_sense: Behaviour | None = None
    finish: Behaviour | None = None
    driver: str | None = None
    version: str = "1.0.0"
    post_sense: Behaviour | None = None
    label: str = ""
    requires: tuple[str, ...] = ()
    when: tuple[Condition, ...] = ()
    order: int = 0
    takes: tuple[str, ...] = ()
    primitives: tuple[type[Primitive[Any]], ...] = ()
    source: tuple[str, int] = field(default=("", 0), compare=False, repr=False)

    def __post_init__(self) -> None:
        keys = [param.key for param in self.description.params]
        named = f"of an implementation of skill '{self.description.name}'"
        for key in (*self.takes, *(argument for condition in self.when for argument in condition.arguments)):
            if key not in keys:
                raise UnknownName("parameter", key, keys, where=named)
        check_behaviour(f"the body {named}", self.body)
        for name, part in self.parts.items():
            check_behaviour(f"a part {named}", part)
            check_nodes(part, name, named)
        written = {name for part in self.nodes for node in walk(part) for name in node.uses().writes}
        for name in sorted(written.intersection(keys)):
            raise DescriptionError(f"Out('{name}') {named}: a parameter is called so; choose another name")
        for part in self.nodes:
            check_references(part, {*keys, *written}, named)

    @property
    def nodes(self) -> tuple[Behaviour, ...]:
        """The behaviours it is made of, in the order in which they run."""
        return tuple(self.parts.values())

    @property
    def parts(self) -> Mapping[str, Behaviour]:
        """The behaviours it is made of by the name of the part, in the order in which they run."""
        names = ("pre_sense", "body", "finish", "post_sense")
        return {name: part for name in names if (part := getattr(self, name)) is not None}


@dataclass(frozen=True, slots=True)
class RunnableDocument:
    """A document that can be run as a module.

    Attributes:
        behaviour: What it does.
        revision: Its revision: kept in the events of each run.
        help: One sentence for people.
        params: The parameters that it declares.
        outputs: Names of the values that its outcome has.
    """

    behaviour: Behaviour
    revision: int
    help: str = ""
    params: tuple[Param, ...] = ()
    outputs: tuple[str, ...] = ()
