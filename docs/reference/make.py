"""Writes the reference of what authors use, from the docstrings and signatures of the code.

``python docs/reference/make.py`` writes the pages beside it; a test holds that they are current.
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

PAGES: Mapping[str, tuple[str, Sequence[str]]] = {
    "descriptions": (
        "Descriptions: skills, primitives, parameters, conditions",
        (
            "skiros_py.authoring:SkillBase",
            "skiros_py.skills.skill:SkillDescription,Skill",
            "skiros_py.skills.primitive:Primitive",
            "skiros_py.skills.parameters",
            "skiros_py.skills.conditions",
            "skiros_py.skills.outcome:Success,Failure",
            "skiros_py.skills.context:RunContext,Effects,Questions",
        ),
    ),
    "behaviours": ("Behaviours: the nodes of skills' bodies, and kinds of document", ("skiros_py.behaviours",)),
    "devices": (
        "Devices: their states, targets and specifications",
        (
            "skiros_py.ports.board:DeviceHandle",
            "skiros_py.devices.gripper:Gripper,GripperState,GripperTarget,GripperSpec",
            "skiros_py.devices.arm:Arm,ArmState,ArmTarget,ArmSpec",
            "skiros_py.devices.mobile_base:Base,BaseState,BaseTwist,BaseSpec",
            "skiros_py.devices.camera:Camera,CameraSpec",
            "skiros_py.devices.localiser:LocaliserState,LocaliserSpec",
            "skiros_py.devices.scanner:ScannerState,ScannerSpec",
            "skiros_py.devices.force_torque:ForceTorqueState,ForceTorqueSpec",
        ),
    ),
    "world": (
        "World model: reading and transactions",
        (
            "skiros_py.world.view:WorldView",
            "skiros_py.world.world:World",
            "skiros_py.world.transaction:Transaction",
            "skiros_py.world.element:Element,Placement",
            "skiros_py.world.terms:Term,Class,Relation,Property,Cardinality",
            "skiros_py.world.reasoners.registry:Reasoner,Answer",
        ),
    ),
}
"""Title and content of each page; content is "module:Name,Name", or a module for all that it exports."""

_ROLE = re.compile(r":\w+:`[~.]*(?:[\w.]*\.)?(\w+)`")
_ITEM = re.compile(r"    (\S[^:]*): (.*)")
_SECTION = re.compile(r"(Args|Attributes|Class attributes|Returns|Raises|Yields):")


def names_of(content: str) -> Iterator[tuple[str, Any]]:
    """Yields the names that a part of a page describes, with their modules' objects."""
    module, _, names = content.partition(":")
    found = import_module(module)
    for name in names.split(",") if names else found.__all__:
        yield name, getattr(found, name)


def page(title: str, contents: Sequence[str]) -> str:
    """Returns the text of a page."""
    head = [f"# {title}", "", "Made from the code by `python docs/reference/make.py`; edit the docstrings instead.", ""]
    return "\n".join([*head, *(line for content in contents for line in _part(content))]).rstrip() + "\n"


def _part(content: str) -> Iterator[str]:
    yield from (f"Import from `{content.partition(':')[0]}`:", "")
    for name, thing in names_of(content):
        yield from (f"## {name}", "")
        if not isinstance(thing, type) and not inspect.isfunction(thing):
            yield from (f"`{name} = {str(thing).replace('typing.', '')}`", "")
            continue
        yield from _described(name, thing)
        for own, member in _members(thing) if isinstance(thing, type) else ():
            yield from (f"### {name}.{own}", "")
            yield from _described(own, member)


def _members(class_: type) -> Iterator[tuple[str, Any]]:
    """Yields the public methods and properties that a class adds to its bases."""
    inherited = {name for base in class_.__mro__[1:] for name in vars(base)}
    for name, member in vars(class_).items():
        function = getattr(member, "fget", None) or getattr(member, "__func__", member)
        if name[0] != "_" and name not in inherited and inspect.isfunction(function) and function.__doc__:
            yield name, member


def _described(name: str, thing: Any) -> Iterator[str]:
    if not isinstance(thing, property):
        yield from (f"```\n{name}{_signature(getattr(thing, '__func__', thing))}\n```", "")
    doc = inspect.getdoc(thing) or ""
    lines = _ROLE.sub(r"`\1`", doc).replace("``", "`").splitlines()
    in_section = False
    for line in lines:
        if section := _SECTION.fullmatch(line):
            in_section = True
            yield from (f"**{section[1]}**", "")
        elif in_section and (item := _ITEM.fullmatch(line)):
            yield f"- `{item[1].strip('`*')}`: {item[2]}"
        else:
            in_section = in_section and (line == "" or line.startswith(" "))
            yield f"  {line.strip()}" if in_section and line else line
    yield ""


def _signature(thing: Any) -> str:
    try:
        text = str(inspect.signature(thing))
    except (TypeError, ValueError):
        return ""
    text = re.sub(r" at 0x[0-9a-f]+|skiros_py(?:\.\w+)*\.|typing\.|collections\.abc\.", "", text)
    return text.replace("'", "")


def main() -> int:
    """Writes the pages."""
    for name, (title, contents) in PAGES.items():
        (Path(__file__).parent / f"{name}.md").write_text(page(title, contents), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
