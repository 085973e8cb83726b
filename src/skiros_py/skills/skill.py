"""Skills: a description (what it needs and what it brings about) and the implementations that do it."""

from __future__ import annotations

from dataclasses import dataclass

from skiros_py.errors import DescriptionError, UnknownName
from skiros_py.skills.composition import Node
from skiros_py.skills.conditions import Condition
from skiros_py.skills.parameters import Param

__all__ = ["Skill", "SkillDescription"]


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
        post: Hold after it; asserted by whoever sensed them, then checked.
        target: Key of the parameter it is done to or for; when the skill keeps failing, this element is left out of
            further plans.
    """

    name: str
    help: str
    agent: str
    target: str
    params: tuple[Param, ...]
    pre: tuple[Condition, ...] = ()
    hold: tuple[Condition, ...] = ()
    post: tuple[Condition, ...] = ()

    def __post_init__(self) -> None:
        if not self.name or ":" in self.name:
            raise DescriptionError(f"skill name '{self.name}': it must not be empty or contain ':'")
        keys = [param.key for param in self.params]
        for condition in (*self.pre, *self.hold, *self.post):
            for argument in condition.arguments:
                if argument not in keys:
                    raise UnknownName("parameter", argument, keys, where=f"in {condition} of skill '{self.name}'")
        for role in (self.agent, self.target):
            if role not in keys:
                raise UnknownName("parameter", role, keys, where=f"as agent or target of skill '{self.name}'")
        if not self.post:
            raise DescriptionError(f"skill '{self.name}' has no postcondition: nobody could ever want it")

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
        return self.param(self.agent).type


@dataclass(frozen=True, slots=True)
class Skill:
    """One way to do what a description promises: pure data, so it can be printed, drawn, exported and run.

    Attributes:
        description: What it promises.
        body: What is done between the checks of pre- and postconditions.
        pre_sense: Sensing before the preconditions are checked, or None.
        finish: Done after the body whether it worked or not (stow the arm), also when the skill is broken off for
            another plan; not when everything is stopped.
        driver: Kind of cell driver it is for ("fake"), or None for every driver that is not a fake.
        version: Version of this implementation.
    """

    description: SkillDescription
    body: Node
    pre_sense: Node | None = None
    finish: Node | None = None
    driver: str | None = None
    version: str = "1.0.0"
