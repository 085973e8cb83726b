"""A child once for each element that fits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

from skiros_py.behaviours.children import Decorator
from skiros_py.messages import Message, joined
from skiros_py.skills.behaviour import Behaviour, Scope, Uses, check_behaviour, check_texts, require
from skiros_py.skills.conditions import Pattern
from skiros_py.skills.outcome import Execution, Failure, Outcome, Success
from skiros_py.skills.parameters import IT
from skiros_py.skills.references import variables


@dataclass(frozen=True, slots=True)
class ForEach(Decorator):
    """The child once for each element that a query finds when its turn comes, in the order of their ids.

    Attributes:
        key: Name by which the child refers to the element: ``P(key)``; no parameter of the skill has it.
        class_: Class of the elements.
        child: What is done; its first failure ends it.
        where: What must hold of an element, which is called ``it`` there or by its ``key``, and of the skill's
            parameters; None for every one of the class.
    """

    kind: ClassVar[str] = "for_each"

    key: str
    class_: str
    child: Behaviour
    where: Pattern | None = None

    def __post_init__(self) -> None:
        check_texts("for each", "the name of its element, then a class such as sk:Box", self.key, self.class_)
        require(":" in self.class_, "for each", "a class such as sk:Box", self.class_)
        check_behaviour("for each", self.child)
        if self.where is not None:
            is_pattern = hasattr(self.where, "rename") and hasattr(self.where, "evaluate")
            require(is_pattern, "for each", "where is a pattern such as Nothing('sk:in', 'it')", self.where)
            object.__setattr__(self, "where", self.where.rename({IT: self.key}))

    @property
    def title(self) -> str:
        """The class of its elements."""
        return (
            f"for each {self.key} of {self.class_.partition(':')[2] or self.class_}{' that fits' if self.where else ''}"
        )

    def uses(self) -> Uses:
        """The element that its child reads, and the pattern by which it is found; there may be none."""
        where = f"'for each {self.key}'"
        names = [name for name in variables(self.where) if name != self.key] if self.where is not None else ()
        return Uses(
            names=tuple((name, where) for name in names),
            patterns=((f"for each {self.key}", self.where),) if self.where is not None else (),
            binds={self.key: self.class_},
            needs="none",
        )

    def run(self, scope: Scope) -> Execution[Outcome]:
        """Runs the child for one element after the other."""
        world = scope.context.world
        given = {key: value for key, value in scope.arguments.items() if isinstance(value, str)}
        fitting = [
            element
            for element in world.instances(self.class_)
            if self.where is None or self.where.evaluate(world, {**given, self.key: element})
        ]
        outcome: Outcome = Success(Message("there is no {thing}", thing=self.key))
        for index, element in enumerate(fitting):
            if index:
                yield
            if not world.has(element):
                continue  # gone meanwhile
            outcome = yield from scope.run(self.child, "0", {self.key: element})
            if isinstance(outcome, Failure):
                return replace(outcome, reason=joined(": ", (element, outcome.reason)))
        return outcome
