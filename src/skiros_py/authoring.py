"""A skill in one class: parameters, conditions and body; what else a skill consists of follows from that.

::

    class Scan(SkillBase):
        arm: str = param("sk:Arm", "The arm that holds the part still.", kind=Kind.HARDWARE)
        part: str = param("sk:Manipulatable", "The part in the gripper.")

        agent, target = "arm", "part"
        post = (SCANNED("part"),)

        def execute(self) -> Execution[Outcome]:
            yield from self.context.sleep(0.5)
            self.assert_effects(reason="the code was read")
            return Success()
"""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
from collections.abc import Callable, Iterator
from typing import Any, ClassVar

from skiros_py.behaviours import AssertEffects, Behaviour, Do, P
from skiros_py.errors import DescriptionError, UnknownName
from skiros_py.skills.conditions import Condition
from skiros_py.skills.outcome import Execution, Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, Output, param, params_of
from skiros_py.skills.primitive import Primitive, generator_problem
from skiros_py.skills.skill import Skill, SkillDescription

__all__ = ["Execution", "Failure", "Kind", "Outcome", "Output", "SkillBase", "Success", "param"]


_EDGE = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")


def skill_name(class_: str) -> str:
    """Returns the name that a skill has by its class ("ScanPart": "scan_part")."""
    return _EDGE.sub("_", class_).lower()


class SkillBase(Primitive[Any]):
    """A skill in one class. Its entry point in the group ``skiros.skills`` names the class.

    From the class are made: the description; a primitive whose code is :meth:`execute`, called ``scan_body`` for a
    skill ``scan``; an implementation that runs it, or ``body``; and one for fakes, which pretends the effects. In a
    run, each parameter is an attribute (``self.part``). The first paragraph of the docstring is the help text.
    Everything else that a :class:`Primitive` has, such as ``takes``, ``recover`` and ``outputs``, can be used, too.

    Class attributes:
        name: Name of the skill; that of the class in small letters where it is left out ("ScanPart": "scan_part").
        agent: Key of the parameter that is the subsystem doing it.
        target: Key of the parameter that it is done to or for.
        pre: Must hold before it starts, over the keys of parameters.
        hold: Must hold while it runs.
        post: Hold after it; ``execute`` asserts them when it has sensed that they are so.
        body: What is done, composed of other modules, instead of ``execute``.
        pre_sense: Sensing before the preconditions are checked.
        post_sense: Sensing before the postconditions are checked.
        finish: Done after the body whether it worked or not.
        requires: Classes of devices that the robot must have for it.
        when: Further conditions under which it can be used.
        label: Its name among several implementations of one description.
        order: Implementations are tried by this number, then by label.
        skill: The implementation that is made of it.
        fake: The one for fakes.
    """

    agent: ClassVar[str] = ""
    target: ClassVar[str] = ""
    pre: ClassVar[tuple[Condition, ...]] = ()
    hold: ClassVar[tuple[Condition, ...]] = ()
    post: ClassVar[tuple[Condition, ...]] = ()
    body: ClassVar[Behaviour | None] = None
    pre_sense: ClassVar[Behaviour | None] = None
    post_sense: ClassVar[Behaviour | None] = None
    finish: ClassVar[Behaviour | None] = None
    requires: ClassVar[tuple[str, ...]] = ()
    when: ClassVar[tuple[Condition, ...]] = ()
    label: ClassVar[str] = ""
    order: ClassVar[int] = 0
    skill: ClassVar[Skill]
    fake: ClassVar[Skill]

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        if SkillBase not in cls.__bases__:
            return  # a variant of the primitive only, such as one under another name
        name = vars(cls).get("name") or skill_name(cls.__name__)
        cls.name = f"{name}_body"
        _check_code(cls, name)
        params = tuple(p for p in params_of(cls.Params) if p.kind is not Kind.CONFIG) if hasattr(cls, "Params") else ()
        description = SkillDescription(
            name=name,
            help=" ".join((cls.__doc__ or "").partition("\n\n")[0].split()),
            agent=cls.agent,
            target=cls.target,
            params=params,
            pre=cls.pre,
            hold=cls.hold,
            post=cls.post,
            duration=cls.duration,
            limit=cls.limit,
        )
        shared: dict[str, Any] = {
            "version": cls.version,
            "label": cls.label,
            "order": cls.order,
            "source": _source(cls),
        }
        cls.skill = Skill(
            description,
            cls.body or Do(cls.name, {p.key: P(p.key) for p in params}),
            pre_sense=cls.pre_sense,
            post_sense=cls.post_sense,
            finish=cls.finish,
            requires=cls.requires,
            when=cls.when,
            takes=cls.takes,
            primitives=() if cls.body else (cls,),
            **shared,
        )
        cls.fake = Skill(description, AssertEffects(cls.duration or 1.0), driver="fake", when=cls.when, **shared)


def _source(class_: type) -> tuple[str, int]:
    """Returns file and line of the statement that makes a class just now."""
    frame = inspect.currentframe()
    while frame is not None and frame.f_globals.get("__name__") != class_.__module__:
        frame = frame.f_back
    return ("", 0) if frame is None else (frame.f_code.co_filename, frame.f_lineno)


def _check_code(class_: type[SkillBase], name: str) -> None:
    """Refuses a class whose code cannot be what is done.

    Raises:
        DescriptionError: Agent or target is missing, there is neither ``execute`` nor ``body``, or both, or ``execute``
            is no generator.
        UnknownName: The code reads an attribute that a run does not have: most are misspelt parameters.
    """
    if missing := next((key for key in ("agent", "target") if not getattr(class_, key)), None):
        right = {"agent": "the subsystem that does it", "target": "what it is done to or for"}[missing]
        raise DescriptionError(f"skill '{name}' has no {missing}: say {missing} = '…', the parameter that is {right}")
    written = class_.execute is not Primitive.execute
    if written is (class_.body is not None):
        raise DescriptionError(
            f"skill '{name}' has {'both execute() and' if written else 'neither execute() nor'} body: give one"
        )
    if problem := generator_problem(class_.execute):
        raise DescriptionError(f"execute() of skill '{name}' {problem}")
    keys = class_._fields
    functions = [function for function in vars(class_).values() if inspect.isfunction(function)]
    used = [one for function in functions for one in _attributes(function)]
    known = {*dir(class_), *keys, *inspect.get_annotations(class_), "context", "params", "loaded"}
    known |= {attribute for attribute, _, is_read in used if not is_read}
    for attribute, line, is_read in used:
        if is_read and attribute not in known:
            raise UnknownName("parameter", attribute, keys, where=f"in line {line} of skill '{name}'")


def _attributes(function: Callable[..., Any]) -> Iterator[tuple[str, int, bool]]:
    """Yields the attributes of its own object that a method uses: name, line, and whether it reads it."""
    try:
        lines, first = inspect.getsourcelines(function)
        tree = ast.parse(textwrap.dedent("".join(lines)))
    except (OSError, TypeError, SyntaxError):
        return  # nothing is known of it
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "self":
            yield node.attr, first + node.lineno - 1, isinstance(node.ctx, ast.Load)
