"""Why there is no plan: which goal condition, which skill would give it, which of its preconditions never holds.

Works on the delete relaxation: facts that can never be true even if nothing were ever undone (Hoffmann & Nebel 2001).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from skiros_py.planning.classes import IS
from skiros_py.planning.literals import BY_CLASS, CAN, HAS, NOT, NOTHING, VALUE, compared
from skiros_py.planning.matching import bindings
from skiros_py.planning.model import Action, Atom
from skiros_py.planning.task import PlanningTask
from skiros_py.world.view import WorldView

__all__ = ["explain"]

Chain = tuple[Atom, ...]

_DEPTH = 5
_SHOWN = 4
"""How many things of one kind are named before it gets long."""


def explain(task: PlanningTask, view: WorldView) -> tuple[str, ...]:
    """Returns one reason for each goal condition that can never hold; empty when each alone could."""
    relaxed = _Relaxation(task, view)
    reasons = []
    for condition, atoms in task.goal:
        missing = [atom for atom in atoms if atom not in relaxed.facts]
        if missing:
            reasons.append(f"{condition} cannot be reached: {relaxed.why(missing[0], {}, ())}")
    return tuple(reasons)


class _Relaxation:
    """The facts that could ever become true, ignoring deletes."""

    def __init__(self, task: PlanningTask, view: WorldView) -> None:
        self.task = task
        self.view = view
        self.ontology = view.ontology
        self.facts: dict[Atom, None] = {}
        self._by_predicate: dict[str, list[Atom]] = {}
        self._possible = [a for a in task.domain.actions if all(self._is_some(v.type) for v in a.parameters)]
        for atom in sorted(task.problem.init):
            self._learn(atom)
        while self._grow():
            pass

    def _learn(self, atom: Atom) -> bool:
        if atom in self.facts:
            return False
        self.facts[atom] = None
        self._by_predicate.setdefault(atom.predicate, []).append(atom)
        return True

    def _grow(self) -> bool:
        news = [
            atom.bind(binding)
            for action in self._possible
            for binding in self.bindings(action, action.pre, {})
            for atom in action.add
        ]
        learned = [self._learn(atom) for atom in news if not any(a.startswith("?") for a in atom.arguments)]
        return any(learned)

    def bindings(self, action: Action, atoms: Sequence[Atom], start: Mapping[str, str]) -> Iterator[dict[str, str]]:
        """Yields every way to make the atoms true at once."""
        return bindings(atoms, self._by_predicate, start, action.types, self._fits)

    def _fits(self, element: str, class_: str) -> bool:
        return not class_ or self.ontology.is_a(self.task.problem.objects[element], class_)

    def _is_some(self, class_: str) -> bool:
        return any(self._fits(thing, class_) for thing in self.task.problem.objects)

    def why(self, atom: Atom, types: Mapping[str, str], chain: Chain) -> str:
        """Says why an atom (perhaps with variables left) never holds.

        Args:
            atom: The atom.
            types: Classes of its variables.
            chain: The atoms that it would be needed for, one for the other: what needs itself needs no second telling.
        """
        givers = [(a, e) for a in self.task.domain.actions for e in a.add if self._could_give(a, e, atom, types)]
        if not givers or atom in chain or len(chain) == _DEPTH:
            return self._where_instead(atom, types)
        action, effect = givers[0]
        start = {
            variable: value
            for variable, value in zip(effect.arguments, atom.arguments, strict=True)
            if variable.startswith("?") and not value.startswith("?")
        }
        narrowed = action.types
        for variable, value in zip(effect.arguments, atom.arguments, strict=True):
            if value.startswith("?") and types.get(value) and self.ontology.is_a(types[value], narrowed[variable]):
                narrowed[variable] = types[value]
        return self._first_obstacle(action, start, narrowed, (*chain, atom))

    def _could_give(self, action: Action, effect: Atom, atom: Atom, types: Mapping[str, str]) -> bool:
        """Tells whether an effect is of the kind that is wanted; a wrong element is for the obstacle to name."""
        if effect.predicate != atom.predicate:
            return False
        own = action.types
        pairs = [
            (own[variable], types[value])
            for variable, value in zip(effect.arguments, atom.arguments, strict=True)
            if value.startswith("?") and own.get(variable) and types.get(value)
        ]
        return all(self.ontology.is_a(a, b) or self.ontology.is_a(b, a) for a, b in pairs)

    def _where_instead(self, atom: Atom, types: Mapping[str, str]) -> str:
        """Says that nothing brings an atom about, and for a placement where the things are instead."""
        plain = f"{self._instead(atom) or f'{self._words(atom, types)} does not hold'}, and no skill brings it about"
        if atom.predicate not in self.ontology.relations or not self.ontology.is_placement(atom.predicate):
            return plain
        moved = atom.arguments[0]
        things = self.view.instances(types[moved]) if moved in types else (moved,) if self.view.has(moved) else ()
        if not things:
            return f"there is no {_local(types.get(moved, moved))}"
        places = ((thing, self.view.placement(thing)) for thing in things[:_SHOWN])
        said = [f"{thing} {self._word(p.relation)} {p.place}" for thing, p in places if p is not None]
        return f"{', '.join(said)}, and no skill takes it from there" if said else plain

    def _first_obstacle(self, action: Action, start: dict[str, str], types: Mapping[str, str], chain: Chain) -> str:
        for variable, value in start.items():
            if not self._fits(value, types[variable]):
                return f"{value} is not a {_local(types[variable])}, which skill '{action.skill}' needs"
        for variable in (v.name for v in action.parameters if v.name not in start):
            class_ = types[variable]
            if not self._is_some(class_):
                return f"there is no {_local(class_)}"
        pre = self._easy_first(action)
        for count in range(1, len(pre) + 1):
            if next(self._typed(action, pre[:count], start, types), None) is None:
                best = next(self._typed(action, pre[: count - 1], start, types), dict(start))
                return self._because(action, pre[count - 1], best, start, types, chain)
        return f"skill '{action.skill}' could do it for other elements only"

    def _typed(
        self, action: Action, atoms: Sequence[Atom], start: Mapping[str, str], types: Mapping[str, str]
    ) -> Iterator[dict[str, str]]:
        for binding in self.bindings(action, atoms, start):
            if all(self._fits(value, types[variable]) for variable, value in binding.items()):
                yield binding

    def _easy_first(self, action: Action) -> list[Atom]:
        """Puts what no skill changes first, so that the obstacle named is the real one."""
        changing = {e.predicate for a in self.task.domain.actions for e in a.add}
        return sorted(action.pre, key=lambda atom: atom.predicate in changing)

    def _because(
        self,
        action: Action,
        atom: Atom,
        best: Mapping[str, str],
        start: Mapping[str, str],
        types: Mapping[str, str],
        chain: Chain,
    ) -> str:
        free = atom.bind(start)
        given = any(e.predicate == atom.predicate for a in self.task.domain.actions for e in a.add)
        if action.skill is None:
            return self.why(free, types, chain) if given else self._plainly(atom.bind({**best, **start}), types)
        need = f"skill '{action.skill}' would do it, but needs that {self._words(free, types)}"
        if not given:
            return f"{need}, and {self._plainly(atom.bind({**best, **start}), types)}"
        why = self.why(free, types, chain)
        return f"{need}; {why}"

    def _plainly(self, atom: Atom, types: Mapping[str, str]) -> str:
        """Says what is the case instead of a fact that no skill changes."""
        if atom.predicate.startswith(NOTHING) and self.view.has(atom.arguments[0]):
            relation = atom.predicate.removeprefix(NOTHING)
            place = atom.arguments[0]
            there = self.view.subjects(relation, place)
            return f"{', '.join(there)} {self._word(relation)} {place}, and no skill takes it away"
        if atom.predicate.startswith(HAS):
            thing, property_ = atom.arguments[0], self._word(atom.predicate.removeprefix(HAS))
            return f"no {_local(types[thing])} has a {property_}" if thing.startswith("?") else f"{thing} has none"
        if atom.predicate.startswith(CAN):
            return "it does not"
        return f"{self._instead(atom) or f'that is not so ({self._words(atom, types)})'}, and no skill changes it"

    def _instead(self, atom: Atom) -> str:
        """Returns what is the case instead of something that was evaluated at the start, or ""."""
        asked = self.task.asked.get(atom.predicate)
        if asked is None or any(argument.startswith("?") for argument in atom.arguments):
            return ""
        return asked.evaluate(self.view, dict(zip(("1", "2"), atom.arguments, strict=False))).text

    def _words(self, atom: Atom, types: Mapping[str, str]) -> str:
        """Returns the atom as a person would say it."""
        names = [a if not a.startswith("?") else _some(_local(types.get(a, "")) or "thing") for a in atom.arguments]
        if atom.predicate.startswith(CAN):
            return f"{names[0]} has the skill '{atom.predicate.removeprefix(CAN)}'"
        if atom.predicate.startswith(HAS):
            return f"{names[0]} has a {self._word(atom.predicate.removeprefix(HAS))}"
        if atom.predicate.startswith(NOTHING):
            return f"nothing {self._word(atom.predicate.removeprefix(NOTHING))} {names[0]}"
        if atom.predicate.startswith(NOT):
            return f"it is not so that {self._words(Atom(atom.predicate.removeprefix(NOT), atom.arguments), types)}"
        if atom.predicate.startswith(IS):
            return f"{names[0]} is {_some(_local(atom.predicate.removeprefix(IS)))}"
        if atom.predicate.startswith(BY_CLASS):
            return (
                f"what is like {names[0]} {self._word(atom.predicate.removeprefix(BY_CLASS))} what is like {names[1]}"
            )
        if atom.predicate.startswith(VALUE):
            property_, comparison = compared(atom.predicate)
            return f"the {self._word(property_)} of {names[0]} is {comparison}"
        return f"{names[0]} {self._word(atom.predicate)} {' '.join(names[1:])}".strip()

    def _word(self, term: str) -> str:
        """Returns what people call a relation or property."""
        if term in self.ontology.relations:
            label = self.ontology.relations[term].label
            return f"is {label}" if self.ontology.is_placement(term) else label
        return self.ontology.properties[term].label if term in self.ontology.properties else _local(term)


def _some(noun: str) -> str:
    return f"{'an' if noun[:1].lower() in 'aeiou' else 'a'} {noun}"


def _local(curie: str) -> str:
    return curie.partition(":")[2] or curie
