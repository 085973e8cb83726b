"""Asks the user to choose, and writes the choice to an element of the world."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_primitives.asking import AskingPrimitive
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.questions import QuestionKind
from skiros_py.world.element import Value
from skiros_py.world.literals import ANY_LITERAL, DATATYPES
from skiros_py.world.vocabulary import ELEMENT


class Choose(AskingPrimitive):
    """Asks the user to choose one of several options; the choice is stored as a property of an element."""

    name: ClassVar[str] = "choose"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        question: str = param("text", "What is asked, such as 'Which colour?'.")
        options: tuple[str, ...] = param("text", "What there is to choose from.", length=0)
        element: str | None = param(ELEMENT, "Where the choice is written to.", kind=Kind.OPTIONAL, default=None)
        property: str | None = param(
            "text", "Its property that gets the choice, such as 'sk:model'.", kind=Kind.OPTIONAL, default=None
        )
        patience: float | None = param(
            "number", "Longest wait for the answer; left out: for ever.", kind=Kind.OPTIONAL, default=None, unit="s"
        )

    def start(self) -> Failure | None:
        """Checks that there are options, and that each could be stored."""
        if len(set(self.params.options)) < 2 or len(set(self.params.options)) < len(self.params.options):
            return Failure(f"options: give two or more that differ, not {list(self.params.options)}")
        if (self.params.element is None) != (self.params.property is None):
            return Failure("element and property: the choice is written to both together, give both or none")
        return self._unwritable() or super().start()

    def execute(self) -> Execution[Outcome]:
        """Asks, and stores the answer."""
        answer = yield from self.ask(QuestionKind.CHOOSE, self.params.question, self.params.options)
        if isinstance(answer, Failure):
            return answer
        element, property_ = self.params.element, self.params.property
        if element is not None and property_ is not None:
            with self.world.transaction(author=self.name, reason=f"a person chose {answer}") as tx:
                tx.set(element, property_, self._value(property_, answer))
        return Success(answer)

    def _unwritable(self) -> Failure | None:
        property_ = self.params.property
        if property_ is None:
            return None
        if property_ not in self.world.ontology.properties:
            return Failure(f"property: there is no property '{property_}'")
        for option in self.params.options:
            try:
                self._value(property_, option)
            except ValueError:
                says = DATATYPES[self.world.ontology.properties[property_].range].says
                return Failure(f"option '{option}' cannot be written as {property_}: it needs {says}")
        return None

    def _value(self, property_: str, answer: str) -> Value:
        datatype = DATATYPES[self.world.ontology.properties[property_].range]
        return answer if datatype is DATATYPES[ANY_LITERAL] else datatype.check(datatype.parse(answer))
