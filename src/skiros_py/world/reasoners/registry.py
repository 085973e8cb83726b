"""The reasoners of a world: their base class, the built-in ones and those of plug-ins, found by what they compute."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, TypeVar

from skiros_py.errors import DescriptionError, SkirosError, UnknownName, UsageError
from skiros_py.messages import Message, joined
from skiros_py.plugins.loading import attempt, load_plugins
from skiros_py.plugins.plugin import Plugin, PluginFault
from skiros_py.world.element import Value
from skiros_py.world.ontology import Ontology
from skiros_py.world.terms import Family
from skiros_py.world.vocabulary import COMPUTED, ELEMENT

if TYPE_CHECKING:
    from skiros_py.world.change import Edit, Writer
    from skiros_py.world.ontology import Ontology
    from skiros_py.world.transaction import Transaction
    from skiros_py.world.view import WorldView


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer whether a computed relation holds.

    Attributes:
        holds: Whether it does.
        reason: Why or why not, in readable form.
        value: The number that decided it (a distance [m], a clearance [m]), or None if there is none.
    """

    holds: bool
    reason: str
    value: float | None = None


@dataclass(frozen=True, slots=True)
class ComputedRelation:
    """A computed relation that holds between two elements; ``value`` as in :class:`Answer`."""

    subject: str
    relation: str
    object: str
    value: float | None = None


@dataclass(frozen=True, slots=True)
class Proposal:
    """A change that is about to take effect.

    Attributes:
        before, after: The world without and with it.
        edits: Its edits.
        author: Its author.
        writer: The kind of author.
    """

    before: WorldView
    after: WorldView
    edits: Sequence[Edit]
    author: str
    writer: Writer


class Reasoner:
    """Evaluates relations and functions over one kind of data; plug-ins of ``skiros.reasoners`` name subclasses.

    A reasoner has no state: it reads everything from the given view, so the same reasoner serves the live world,
    snapshots and hypothetical views.

    Attributes:
        name: Its name in messages.
        relations: CURIEs of the computed relations that it evaluates, each declared below ``sk:computed``.
        functions: Functions for SPARQL by CURIE (``BIND(sk:distance(?a, ?b) AS ?d)``), called with the view and the
            arguments: elements as ids, literals as values; they return None if there is no answer.
        keys: Names of the data that :meth:`data` reads and :meth:`store` writes.
    """

    name: ClassVar[str]
    relations: ClassVar[frozenset[str]] = frozenset()
    functions: ClassVar[Mapping[str, Callable[..., Value | None]]] = MappingProxyType({})
    keys: ClassVar[frozenset[str]] = frozenset()

    def answer(self, view: WorldView, subject: str, relation: str, object_: str) -> Answer:
        """Returns whether one of its :attr:`relations` holds between two elements, and why.

        A subclass with relations overrides this; one that does not is refused when it is loaded.
        """
        raise DescriptionError(f"reasoner '{self.name}' does not evaluate {relation}: it has no method 'answer'")

    def pairs(
        self, view: WorldView, relation: str, subjects: Iterable[str], objects: Sequence[str]
    ) -> Iterator[tuple[str, str]]:
        """Yields the pairs between which a relation holds; override it if evaluating many together is faster."""
        for subject in subjects:
            for object_ in objects:
                if subject != object_ and self.answer(view, subject, relation, object_).holds:
                    yield subject, object_

    def between(self, view: WorldView, subject: str, object_: str) -> tuple[ComputedRelation, ...]:
        """Returns every one of its relations that holds from one element to another, with values, sorted."""
        answers = ((relation, self.answer(view, subject, relation, object_)) for relation in sorted(self.relations))
        return tuple(ComputedRelation(subject, r, object_, a.value) for r, a in answers if a.holds)

    def data(self, view: WorldView, element: str, key: str) -> Value | None:
        """Returns data of an element in the form named by the key ("pose in the map"), or None if it has none.

        Raises:
            UsageError: It has no such key.
        """
        raise UsageError(f"{self.name} reads no '{key}'")

    def store(self, tx: Transaction, element: str, key: str, value: Value) -> None:
        """Writes data of an element in the form named by the key.

        Raises:
            UsageError: It has no such key.
        """
        raise UsageError(f"{self.name} stores no '{key}'")

    def similarity(self, view: WorldView, a: str, b: str) -> float | None:
        """Returns the similarity of two elements, from 0 to 1, or None if it is unknown."""
        return None

    def classify(self, view: WorldView, element: str, classes: Sequence[str]) -> tuple[tuple[str, float], ...]:
        """Returns the likelihood of each class for an element, highest first; unknown ones are left out."""
        return ()

    def veto(self, proposal: Proposal) -> str | None:
        """Returns why a change must not take effect, or None. Called for every change, so it must be fast."""
        return None


def computed_others(
    view: WorldView, element: str, relation: str, *, backwards: bool = False, among: Sequence[str] | None = None
) -> tuple[str, ...]:
    """Returns ids of the elements to which a computed relation holds, sorted.

    Args:
        view: The world.
        element: Id of the subject.
        relation: CURIE of the relation.
        backwards: True where the element is the object, and its subjects are wanted.
        among: Ids of the candidates; by default, all elements of the scene.

    Raises:
        UnknownName: There is no such element, or no reasoner computes the relation.
    """
    view.element(element)
    found: set[str] = set()
    for below in view.reasoners.narrowest(view.ontology, relation):
        declared = view.ontology.relation(below)
        end = declared.domain if backwards else declared.range
        others = view.instances(end or ELEMENT) if among is None else among
        ends = (others, (element,)) if backwards else ((element,), others)
        found.update(pair[not backwards] for pair in view.reasoners.pairs(view, below, *ends))
    return tuple(sorted(found))


# ---------------------------------------------------------------- the registry


_log = logging.getLogger(__name__)
_T = TypeVar("_T")


class Reasoners(Sequence[Reasoner]):
    """Reasoners, no two of which compute the same relation.

    Raises:
        UsageError: Two do.
    """

    def __init__(self, reasoners: Sequence[Reasoner] = ()) -> None:
        self._all = tuple(reasoners)
        self._by_relation: dict[str, Reasoner] = {}
        for reasoner in self._all:
            for relation in sorted(reasoner.relations):
                other = self._by_relation.setdefault(relation, reasoner)
                if other is not reasoner:
                    raise UsageError(f"reasoners {other.name} and {reasoner.name} both compute {relation}")
        self._vetoing = tuple(r for r in self._all if type(r).veto is not Reasoner.veto)

    def __getitem__(self, at: int) -> Reasoner:  # type: ignore[override]  # slices are not needed
        return self._all[at]

    def __len__(self) -> int:
        return len(self._all)

    def of(self, relation: str) -> Reasoner:
        """Returns the reasoner that computes a relation.

        Raises:
            UnknownName: None does.
        """
        if relation not in self._by_relation:
            raise UnknownName("computed relation", relation, self._by_relation, where="(no reasoner computes it)")
        return self._by_relation[relation]

    def computes(self, relation: str) -> bool:
        """Returns True when one of them computes the relation."""
        return relation in self._by_relation

    def narrowest(self, ontology: Ontology, relation: str) -> tuple[str, ...]:
        """Returns the computed relation, or those below it that a reasoner computes.

        Raises:
            UnknownName: There is none.
        """
        found = tuple(below for below in ontology.sub_relations(relation) if below in self._by_relation)
        if not found:
            self.of(relation)
        return found

    def answer(self, view: WorldView, subject: str, relation: str, object_: str) -> Answer:
        """Returns whether a computed relation, or a sub-relation, holds, and why.

        Raises:
            UnknownName: There is no such element, or no reasoner computes the relation.
            DescriptionError: Its reasoner failed.
        """
        answers = [self._answer(view, subject, r, object_) for r in self.narrowest(view.ontology, relation)]
        return next((answer for answer in answers if answer.holds), answers[0])

    def pairs(
        self, view: WorldView, relation: str, subjects: Iterable[str], objects: Iterable[str]
    ) -> list[tuple[str, str]]:
        """Returns the pairs between which exactly this computed relation holds.

        Raises:
            UnknownName: No reasoner computes the relation.
            DescriptionError: Its reasoner failed.
        """
        reasoner, declared = self.of(relation), view.ontology.relation(relation)
        first = _fitting(view, subjects, declared.domains)
        second = _fitting(view, objects, declared.ranges)
        return _guarded(reasoner, lambda: list(reasoner.pairs(view, relation, first, second)))

    def between(self, view: WorldView, subject: str, object_: str) -> tuple[ComputedRelation, ...]:
        """Returns all computed relations that hold from one element to another, reasoner by reasoner.

        Relations whose declared ends do not fit the elements are left out.
        """
        relations = view.ontology.relations
        held = (r for one in self._all for r in _guarded(one, partial(one.between, view, subject, object_)))
        return tuple(
            r for r in held if r.relation not in relations or not _misfit(view, r.subject, r.relation, r.object)
        )

    def vetoes(self, proposal: Proposal) -> tuple[str, ...]:
        """Returns the objections of reasoners to a change."""
        found: list[str] = []
        for reasoner in self._vetoing:
            try:
                objection = _guarded(reasoner, partial(reasoner.veto, proposal))
            except SkirosError:  # it has no objection then: one bad plug-in must not block all writes
                _log.exception("reasoner '%s' could not say whether it objects to a change", reasoner.name)
            else:
                found += [joined(": ", (reasoner.name, objection))] if objection else []
        return tuple(found)

    def _answer(self, view: WorldView, subject: str, relation: str, object_: str) -> Answer:
        misfit = _misfit(view, subject, relation, object_)
        if misfit:
            return Answer(False, misfit)
        reasoner = self.of(relation)
        answer = _guarded(reasoner, lambda: reasoner.answer(view, subject, relation, object_))
        if not isinstance(answer, Answer) or not isinstance(answer.holds, bool):
            raise DescriptionError(f"reasoner '{reasoner.name}' must answer with an Answer, not with {answer!r:.100}")
        return answer


def _guarded(reasoner: Reasoner, call: Callable[[], _T]) -> _T:
    """Calls a plug-in; its errors name it."""
    try:
        return call()
    except SkirosError:
        raise
    except (Exception, SystemExit) as error:
        raise DescriptionError(f"reasoner '{reasoner.name}' failed: {type(error).__name__}: {error}") from error


def _fitting(view: WorldView, names: Iterable[str], end: tuple[tuple[str, ...], ...]) -> tuple[str, ...]:
    return tuple(name for name in names if not view.ontology.missed_end(view.element(name).type, end))


def _misfit(view: WorldView, subject: str, relation: str, object_: str) -> str:
    """Why a relation, as declared, cannot hold between two elements; empty if it can."""
    declared = view.ontology.relation(relation)
    for name, allowed in ((subject, declared.domains), (object_, declared.ranges)):
        type_ = view.element(name).type
        missed = view.ontology.missed_end(type_, allowed)
        if missed:
            said = {"relation": relation, "kind": " or ".join(missed), "thing": name, "other": type_}
            return Message("{relation} is about a {kind}, and {thing} is a {other}", **said)
    return ""


NO_REASONERS = Reasoners()
"""For worlds without computed relations."""


GROUP = "skiros.reasoners"
"""Entry points of this group name subclasses of :class:`~skiros_py.world.reasoners.registry.Reasoner`."""


def load_reasoners(ontology: Ontology | None = None) -> tuple[Reasoners, tuple[PluginFault, ...]]:
    """Loads all reasoners, in the order of their entry points' names, the built-in ones first.

    Args:
        ontology: Must declare the relations that they compute; None to skip that check.

    Returns:
        Those that can be used together; and the faults of the others, which are left out: they did not load, are no
        reasoners, have the name or a relation of an earlier one, do not evaluate their relations, or have relations
        that the ontology does not declare as computed.
    """
    plugins, broken = load_plugins(GROUP)
    good: list[Reasoner] = []
    faults = list(broken)
    for plugin in sorted(plugins, key=lambda plugin: not plugin.is_builtin):
        made = attempt(plugin, partial(_usable, plugin, good, ontology))
        if isinstance(made, PluginFault):
            faults.append(made)
        else:
            good.append(made)
    return Reasoners(good), tuple(faults)


def _usable(plugin: Plugin, others: Sequence[Reasoner], ontology: Ontology | None) -> Reasoner | PluginFault:
    """Returns the reasoner of a plug-in, or why it cannot be used beside the others."""
    class_ = plugin.value
    if not isinstance(class_, type) or not issubclass(class_, Reasoner):
        return plugin.fault(f"it is a {type(class_).__name__}, nothing for reasoners: name a subclass of Reasoner")
    reasoner = class_()
    if not isinstance(getattr(reasoner, "name", None), str) or not reasoner.name:
        return plugin.fault("it has no name")
    if any(reasoner.name == other.name for other in others):
        return plugin.fault(f"there is a reasoner '{reasoner.name}' already")
    try:
        Reasoners([*others, reasoner])
    except UsageError as error:
        return plugin.fault(str(error))
    declared = ontology.relations.items() if ontology is not None else ()
    unknown = reasoner.relations - {name for name, relation in declared if relation.family is Family.COMPUTED}
    if unknown and ontology is not None:
        return plugin.fault(f"no ontology declares {', '.join(sorted(unknown))} below {COMPUTED}")
    if reasoner.relations and class_.answer is Reasoner.answer:
        computed = ", ".join(sorted(reasoner.relations))
        return plugin.fault(f"reasoner '{reasoner.name}' declares {computed} but has no method 'answer'")
    return reasoner
