"""What an entry point of each group must name, in one table."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, is_dataclass
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from skiros_py.behaviours.document import DocumentKind
from skiros_py.errors import SkirosError
from skiros_py.plugins import Plugin
from skiros_py.ports.adapters import Adapter, adapter_problem
from skiros_py.ports.device import DeviceSpec
from skiros_py.ports.kinds import device_problem
from skiros_py.ports.models import RobotModel
from skiros_py.skills.behaviour import Behaviour
from skiros_py.skills.conditions import ConditionType
from skiros_py.skills.parameters import params_of
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.world.reasoners.reasoner import Reasoner


@dataclass(frozen=True, slots=True)
class Kind:
    """One group of entry points.

    Attributes:
        group: The group ("skiros.skills").
        names: What an entry point of it must name, for people.
        is_one: Tells whether an object is such a thing.
        finer: Says what is wrong with one that is, or None.
    """

    group: str
    names: str
    is_one: Callable[[Any], bool]
    finer: Callable[[Plugin], str | None] = lambda _: None

    def problem(self, plugin: Plugin) -> str | None:
        """Returns why a plug-in cannot be used, or None."""
        if not self.is_one(plugin.value):
            kind = self.group.partition(".")[2]
            return f"it is a {type(plugin.value).__name__}, nothing for {kind}: name {self.names}"
        return self.finer(plugin)


def skills_of(plugin: Plugin) -> Mapping[str, Skill]:
    """Returns the skills that an entry point names: one under its name, several as ``name[1]``, ``name[2]``, …."""
    if isinstance(plugin.value, Skill):
        return {plugin.name: plugin.value}
    return {f"{plugin.name}[{number}]": skill for number, skill in enumerate(plugin.value, start=1)}


def _is_skill(value: Any) -> bool:
    if isinstance(value, Sequence) and not isinstance(value, str) and value:
        return all(isinstance(one, Skill) for one in value)
    return isinstance(value, Skill)


def _wrong_skill(plugin: Plugin) -> str | None:
    for skill in skills_of(plugin).values():
        description: Any = skill.description  # nothing keeps a dataclass from being made with something else
        if not isinstance(description, SkillDescription):
            return f"its description is a {type(description).__name__}, not a SkillDescription"
        texts = {"name": description.name, "label": skill.label, "driver": skill.driver or ""}
        for what, text in texts.items():
            if (wrong := _no_text(text)) is not None:
                return f"its {what} is {wrong}, not a text"
    return None


def _wrong_condition(plugin: Plugin) -> str | None:
    wrong = _no_text(plugin.value.name)
    return f"its name is {wrong}, not a word" if wrong is not None else None


def _no_text(value: Any) -> str | None:
    """Writes out what should be a text and is none."""
    return None if isinstance(value, str) else repr(value)


def _wrong_primitive(plugin: Plugin) -> str | None:
    class_ = plugin.value
    own = getattr(class_, "name", None)
    if own != plugin.name:
        called = f"it calls itself '{own}'" if own else "it has no name"
        return f"{called}: compositions find it as '{plugin.name}', so both must be the same"
    if not is_dataclass(getattr(class_, "Params", None)):
        return "it has no Params: a frozen dataclass, empty where it takes nothing"
    try:
        params_of(class_.Params)
    except SkirosError as error:
        return str(error)
    missing = sorted(class_.__abstractmethods__) if inspect.isabstract(class_) else []
    return f"it does not define {', '.join(missing)}" if missing else None


def _wrong_behaviour(plugin: Plugin) -> str | None:
    class_ = plugin.value
    own = getattr(class_, "kind", None)
    if own != plugin.name:
        return f"its kind is {own!r}: documents find it as '{plugin.name}', so both must be the same"
    missing = sorted(class_.__abstractmethods__) if inspect.isabstract(class_) else []
    return f"it does not define {', '.join(missing)}" if missing else None


def _instance_of(*types: type) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, types)


def _subclass_of(base: type) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, type) and issubclass(value, base)


_is_files = _instance_of(Path, Traversable)
_is_robot = _instance_of(RobotModel, Path, Traversable)

KINDS: Mapping[str, Kind] = {
    kind.group: kind
    for kind in (
        Kind("skiros.skills", "a Skill, or a sequence of them", _is_skill, _wrong_skill),
        Kind("skiros.primitives", "a subclass of Primitive", _subclass_of(Primitive), _wrong_primitive),
        Kind("skiros.behaviours", "a subclass of Behaviour", _subclass_of(Behaviour), _wrong_behaviour),
        Kind("skiros.documents", "a subclass of DocumentKind", _subclass_of(DocumentKind), _wrong_behaviour),
        Kind("skiros.conditions", "a ConditionType", _instance_of(ConditionType), _wrong_condition),
        Kind("skiros.reasoners", "a subclass of Reasoner", _subclass_of(Reasoner)),
        Kind("skiros.planners", "what makes a Planner when it is called", callable),
        Kind("skiros.devices", "a subclass of DeviceSpec", _subclass_of(DeviceSpec), device_problem),
        Kind("skiros.adapters", "an Adapter", _instance_of(Adapter), adapter_problem),
        Kind("skiros.drivers", "what makes a CellDriver when it is called", callable),
        Kind("skiros.signals", "a function of the cell that returns signal providers", callable),
        Kind("skiros.engines", "what makes a simulation Engine when it is called", callable),
        Kind("skiros.ontologies", "a package with ontology files, or a Path", _is_files),
        Kind("skiros.robots", "a RobotModel, a package with Turtle files, or a Path", _is_robot),
        Kind("skiros.scenes", "a package with scene files, or a Path", _is_files),
        Kind("skiros.pages", "the Path of a folder of built web pages", _instance_of(Path)),
        Kind("skiros.topics", "a function that takes a Recorder", callable),
    )
}
"""By group."""
