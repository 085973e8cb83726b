"""Asks the user to bring something to a place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_primitives.asking import AskingPrimitive
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.questions import QuestionKind
from skiros_py.skills.surroundings import set_pose
from skiros_py.world.element import Placement
from skiros_py.world.names import local_name
from skiros_py.world.transaction import Transaction
from skiros_py.world.vocabulary import CONTAINER, IN, MANIPULATABLE, MISSED_LOOKS, MISSING

_DONE, _CANNOT = "done", "cannot"


class Refill(AskingPrimitive):
    """Asks the user to bring something to a place; it has to be located before it is used."""

    name: ClassVar[str] = "refill"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        place: str = param(CONTAINER, "Where it is wanted.")
        what: str = param("class", "The class of thing that is wanted, such as kitting:Starter.")
        count: int = param("integer", "How many.", kind=Kind.OFFLINE, default=1)
        patience: float | None = param(
            "number", "Longest wait for the answer; left out: for ever.", kind=Kind.OPTIONAL, default=None, unit="s"
        )

    def start(self) -> Failure | None:
        """Checks that the thing can be requested."""
        if not self.world.ontology.is_a(self.params.what, MANIPULATABLE):
            return Failure(f"what: {self.params.what} is no {MANIPULATABLE}, so nobody can bring it")
        if self.params.count < 1:
            return Failure(f"count: one or more, not {self.params.count}")
        return super().start()

    def execute(self) -> Execution[Outcome]:
        """Asks, and takes the answer as true until a look contradicts it."""
        place, count = self.params.place, self.params.count
        text = f"Bring {count} x {local_name(self.params.what)} to {self.world.element(place).label} ({place})"
        answer = yield from self.ask(QuestionKind.REFILL, text, (_DONE, _CANNOT))
        if isinstance(answer, Failure):
            return answer
        if answer != _DONE:
            return Failure(f"a person cannot do this: {text}")
        with self.world.transaction(author=self.name, reason=f"a person brought {count} x {self.params.what}") as tx:
            self._unverify(tx)
            self._bring(tx)
        return Success(f"{place} was refilled")

    def _unverify(self, tx: Transaction) -> None:
        """Marks the place's things as unverified: the user may have moved them."""
        for thing in self.world.subjects(IN, self.params.place):
            if self.world.ontology.is_a(self.world.element(thing).type, MANIPULATABLE):
                self._forget(tx, thing)

    def _bring(self, tx: Transaction) -> None:
        """Adds what was brought: first as the missing things of its class, which looks identify; the rest is new."""
        place = Placement(IN, self.params.place)
        missing = [e for e in self.world.instances(self.params.what) if self.world.value(e, MISSING) is True]
        found = [e for e in missing if self.world.placement(e) != place][: self.params.count]
        for thing in found:
            tx.place(thing, IN, self.params.place)
            self._forget(tx, thing)
        for _ in range(self.params.count - len(found)):
            tx.add(self.params.what, placement=place)

    def _forget(self, tx: Transaction, thing: str) -> None:
        tx.set(thing, MISSING, None)
        tx.set(thing, MISSED_LOOKS, None)
        set_pose(tx, self.world, thing, None)
