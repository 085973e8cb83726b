"""Modules as people see them, and which implementations of skills fit a subsystem."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from skiros_py.skills.context import RunContext
from skiros_py.skills.parameters import Kind, Output, Param
from skiros_py.skills.skill import Skill
from skiros_py.skills.surroundings import owner
from skiros_py.world.view import pieces
from skiros_py.world.vocabulary import REFINED_SKILLS


@dataclass(frozen=True, slots=True)
class ModuleInfo:
    """One module, for people who choose one.

    Attributes:
        name: Its name.
        kind: "skill", "primitive" or "document".
        help: One sentence.
        params: Its parameters.
        version: Version of the (first) implementation.
        implementations: Labels of a skill's implementations, in the order in which they are tried.
        outputs: The values that its outcome has; none of a skill.
    """

    name: str
    kind: str
    help: str
    params: tuple[Param, ...]
    version: str
    implementations: tuple[str, ...] = ()
    outputs: tuple[Output, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """Returns it as plain data; planning parameters are left out, people never see them."""
        shown = [p for p in self.params if p.kind is not Kind.PLANNING]
        return {
            "name": self.name,
            "kind": self.kind,
            "help": self.help,
            "version": self.version,
            "implementations": list(self.implementations),
            "parameters": [
                {"key": p.key, "type": p.type_name, "kind": p.kind.value, "help": p.help, "unit": p.unit} for p in shown
            ],
            "outputs": [
                {"name": o.name, "type": o.param.type_name, "help": o.help, "unit": o.unit} for o in self.outputs
            ],
        }


def choose(skills: Sequence[Skill], context: RunContext, agent: str, driver: str) -> dict[str, tuple[Skill, ...]]:
    """Takes the implementations that fit the subsystem and its robot, by skill, in the order of trying.

    What such a subsystem has in a refined form only is left out, also where no refined form could be loaded.
    """
    view = context.world
    robot = owner(view, agent) or agent
    there = [view.element(e).type for e in pieces(view, robot)]
    refined = str(view.ontology.class_value(view.element(agent).type, REFINED_SKILLS) or "").split()
    chosen: dict[str, list[Skill]] = {}
    for skill in (one for one in skills if one.description.name not in refined):
        wanted = skill.driver == driver if driver == "fake" else skill.driver in (None, driver)
        equipped = all(any(view.ontology.is_a(t, class_) for t in there) for class_ in skill.requires)
        if wanted and equipped and view.ontology.is_a(view.element(agent).type, skill.description.agent_class):
            chosen.setdefault(skill.description.name, []).append(skill)
    return {name: tuple(sorted(ways, key=lambda s: (s.order, s.label))) for name, ways in chosen.items()}
