"""Asks the user: to choose, to confirm, or to bring something to a place."""

from __future__ import annotations

from typing import Any, ClassVar

from skiros_py.messages import Message
from skiros_py.skills.context import QuestionKind
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, Output, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.world import vocabulary as v
from skiros_py.world.element import Placement, Value
from skiros_py.world.literals import ANY_LITERAL, DATATYPES
from skiros_py.world.names import local_name
from skiros_py.world.poses import forget_looks
from skiros_py.world.transaction import Transaction


def _patience() -> Any:
    return param("number", "Longest wait for the answer; left out: for ever.", kind=Kind.OPTIONAL, unit="s")


class AskingPrimitive(Primitive[Any]):
    """Base of the primitives that ask the user; their parameters have a field ``patience`` [s], None for no limit."""

    def start(self) -> Failure | None:
        """Fails at once if no user interface could show the question."""
        if not self.context.questions.heard:
            return Failure(Message("{name}: there is no one to answer; run it where a person watches", name=self.name))
        return None

    def ask(self, kind: QuestionKind, text: str, options: tuple[str, ...]) -> Execution[str | Failure]:
        """Asks a question and waits for the answer, one of the options; a question no longer needed is withdrawn."""
        questions, asked_at = self.context.questions, self.context.now
        asked = questions.ask(kind, text, options, asker=self.name, time=asked_at)
        self.progress(1, text)
        patience = self.params.patience
        try:
            while asked.answer is None and (patience is None or self.context.now < asked_at + patience):
                yield
        finally:
            questions.withdraw(asked)
        if asked.answer is None:
            return Failure(Message("no answer within {seconds:g} s: {text}", seconds=patience, text=text))
        self.progress(2, Message("{by} answered: {answer}", by=asked.by, answer=asked.answer))
        return asked.answer


class Choose(AskingPrimitive):
    """Asks the user to choose one of several options; the choice is stored as a property of an element."""

    name: ClassVar[str] = "choose"
    outputs: ClassVar[tuple[Output, ...]] = (Output("answer", "text", "What the person chose."),)

    question: str = param("text", "What is asked, such as 'Which colour?'.")
    options: tuple[str, ...] = param("text", "What there is to choose from.", length=0)
    element: str | None = param(v.ELEMENT, "Where the choice is written to.", kind=Kind.OPTIONAL)
    property: str | None = param("text", "Its property that gets the choice, such as 'sk:model'.", kind=Kind.OPTIONAL)
    patience: float | None = _patience()

    def start(self) -> Failure | None:
        """Checks that there are options, and that each could be stored."""
        if len(set(self.options)) < 2 or len(set(self.options)) < len(self.options):
            return Failure(Message("options: give two or more that differ, not {options}", options=list(self.options)))
        if (self.element is None) != (self.property is None):
            return Failure(Message("element and property: the choice is written to both together, give both or none"))
        return self._unwritable() or super().start()

    def execute(self) -> Execution[Outcome]:
        """Asks, and stores the answer."""
        answer = yield from self.ask(QuestionKind.CHOOSE, self.question, self.options)
        if isinstance(answer, Failure):
            return answer
        element, property_ = self.element, self.property
        if element is not None and property_ is not None:
            with self.world.transaction(
                author=self.name, reason=Message("a person chose {answer}", answer=answer)
            ) as tx:
                tx.set(element, property_, self._value(property_, answer))
        return Success(answer, {"answer": answer})

    def _unwritable(self) -> Failure | None:
        property_ = self.property
        if property_ is None:
            return None
        if property_ not in self.world.ontology.properties:
            return Failure(Message("property: there is no property '{property}'", property=property_))
        for option in self.options:
            try:
                self._value(property_, option)
            except ValueError:
                says = DATATYPES[self.world.ontology.properties[property_].range].says
                return Failure(
                    Message(
                        "option '{option}' cannot be written as {property}: it needs {says}",
                        option=option,
                        property=property_,
                        says=says,
                    )
                )
        return None

    def _value(self, property_: str, answer: str) -> Value:
        datatype = DATATYPES[self.world.ontology.properties[property_].range]
        return answer if datatype is DATATYPES[ANY_LITERAL] else datatype.check(datatype.parse(answer))


class Confirm(AskingPrimitive):
    """Asks the user a yes-or-no question; "no" is a failure."""

    name: ClassVar[str] = "confirm"

    question: str = param("text", "What is asked, such as 'Is the door closed?'.")
    patience: float | None = _patience()

    def execute(self) -> Execution[Outcome]:
        """Asks."""
        answer = yield from self.ask(QuestionKind.CONFIRM, self.question, ("yes", "no"))
        if isinstance(answer, Failure):
            return answer
        return (
            Success(Message("yes"))
            if answer == "yes"
            else Failure(Message("a person said no: {question}", question=self.question))
        )


_DONE, _CANNOT = "done", "cannot"


class Refill(AskingPrimitive):
    """Asks the user to bring something to a place; it has to be located before it is used."""

    name: ClassVar[str] = "refill"

    place: str = param(v.CONTAINER, "Where it is wanted.")
    what: str = param("class", "The class of thing that is wanted, such as kitting:Starter.")
    count: int = param("integer", "How many.", kind=Kind.OFFLINE, default=1)
    patience: float | None = _patience()

    def start(self) -> Failure | None:
        """Checks that the thing can be requested."""
        if not self.world.ontology.is_a(self.what, v.MANIPULATABLE):
            return Failure(
                Message(
                    "what: {what} is no {kind}, so a person cannot bring it",
                    what=self.what,
                    kind=v.MANIPULATABLE,
                )
            )
        if self.count < 1:
            return Failure(Message("count: one or more, not {count}", count=self.count))
        return super().start()

    def execute(self) -> Execution[Outcome]:
        """Asks, and takes the answer as true until a look contradicts it."""
        place, count = self.place, self.count
        text = Message(
            "Bring {count} x {what} to {label} ({place})",
            count=count,
            what=local_name(self.what),
            label=self.world.element(place).label,
            place=place,
        )
        answer = yield from self.ask(QuestionKind.REFILL, text, (_DONE, _CANNOT))
        if isinstance(answer, Failure):
            return answer
        if answer != _DONE:
            return Failure(Message("a person cannot do this: {text}", text=text))
        with self.world.transaction(
            author=self.name, reason=Message("a person brought {count} x {what}", count=count, what=self.what)
        ) as tx:
            for thing in self.world.subjects(v.IN, place):  # the person may have moved what was there
                if self.world.ontology.is_a(self.world.element(thing).type, v.MANIPULATABLE):
                    forget_looks(tx, thing)
            self._bring(tx)
        return Success(Message("{place} was refilled", place=place))

    def _bring(self, tx: Transaction) -> None:
        """Adds what was brought: first as the missing things of its class, which looks identify; the rest is new."""
        place = Placement(v.IN, self.place)
        missing = [e for e in self.world.instances(self.what) if self.world.value(e, v.MISSING) is True]
        found = [e for e in missing if self.world.placement(e) != place][: self.count]
        for thing in found:
            tx.place(thing, v.IN, self.place)
            forget_looks(tx, thing)
        for _ in range(self.count - len(found)):
            tx.add(self.what, placement=place)
