"""The words that a goal may use: conditions, classes and elements, by their own names or as PDDL spells them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property

from skiros_py.errors import UnknownName, UsageError
from skiros_py.planning.domain.names import NameMap
from skiros_py.skills.conditions import ConditionType
from skiros_py.world.names import local_name
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import ELEMENT


class Lexicon:
    """Looks words up, for one goal.

    Args:
        view: The world, for elements and classes.
        conditions: The condition words there are.
    """

    def __init__(self, view: WorldView, conditions: Mapping[str, ConditionType]) -> None:
        self._view = view
        self._conditions = conditions
        self._spelt_classes: dict[str, NameMap] = {}
        self._spelt_elements: dict[str, NameMap] = {}

    def word(self, word: str) -> ConditionType:
        """Returns a condition's word, whatever its capitals.

        Raises:
            UnknownName: There is none.
        """
        if word.casefold() not in self._words:
            raise UnknownName("condition", word, self._conditions, where="in the goal")
        return self._words[word.casefold()]

    @cached_property
    def _words(self) -> dict[str, ConditionType]:
        spelt = NameMap(sorted(self._conditions))
        own = {name.casefold(): type_ for name, type_ in self._conditions.items()}
        return {spelt.pddl(name): type_ for name, type_ in self._conditions.items()} | own

    def class_(self, name: str, above: str) -> str | None:
        """Returns the CURIE of a class, or None where no class at or below another one is called so.

        Raises:
            UsageError: Classes of several ontologies are called so.
        """
        below = self._view.ontology.subclasses(above)
        if name in below:
            return name
        named = [curie for curie in below if local_name(curie) == name]
        if len(named) > 1:
            raise UsageError(f"{name} may be {' or '.join(named)}: write the one that is meant")
        if above not in self._spelt_classes:
            self._spelt_classes[above] = NameMap(below)
        return named[0] if named else _back(self._spelt_classes[above], name)

    def is_taken(self, variable: str) -> bool:
        """Tells whether an element or a class has this very name: what is written so would be mistaken for it."""
        return self._view.has(variable) or variable in map(local_name, self._view.ontology.subclasses(ELEMENT))

    def element(self, name: str, class_: str) -> str | None:
        """Returns the id of an element that is called so, or None.

        An id comes first, then a class, for which None is returned (a part without a label of its own is called like
        its class), then a label that no other element has, one of the scene before an abstract one, then the id of an
        element of the wanted class in PDDL's spelling.

        Raises:
            UsageError: Classes of several ontologies are called so.
        """
        if self._view.has(name):
            return name
        if self.class_(name, class_) is not None:
            return None
        labelled = self._labels.get(name) or self._abstract_labels.get(name, [])
        if len(labelled) == 1:
            return labelled[0]
        if class_ not in self._spelt_elements:
            self._spelt_elements[class_] = NameMap((*self._view.instances(class_), *self._view.abstracts(class_)))
        return _back(self._spelt_elements[class_], name)

    @cached_property
    def _labels(self) -> dict[str, list[str]]:
        return self._by_label(self._view.instances(ELEMENT))

    @cached_property
    def _abstract_labels(self) -> dict[str, list[str]]:
        return self._by_label(self._view.abstracts(ELEMENT))

    def _by_label(self, elements: Iterable[str]) -> dict[str, list[str]]:
        found: dict[str, list[str]] = {}
        for element in elements:
            found.setdefault(self._view.element(element).label, []).append(element)
        return found


def _back(spelt: NameMap, name: str) -> str | None:
    return spelt.back(name) if spelt.gives(name.lower()) else None
