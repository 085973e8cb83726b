"""Finds elements for the parameters of a skill that were left out; the result is values with reasons."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

from skiros_py.messages import Message
from skiros_py.skills.conditions import Condition, Verdict
from skiros_py.skills.inference.search import Search, Solution, choose, conjuncts
from skiros_py.skills.parameters import IT, Param, missing
from skiros_py.skills.references import variables
from skiros_py.skills.skill import SkillDescription, nearest_first
from skiros_py.world.view import WorldView


@dataclass(frozen=True, slots=True)
class Inferred:
    """Every required parameter is specified.

    Attributes:
        values: Value by key of every parameter; None for optional ones that stay unspecified.
        reasons: Why this one, by key, of what was inferred ("of 3 that fit, the first by id").
    """

    values: Mapping[str, Any]
    reasons: Mapping[str, str]

    def lines(self) -> list[str]:
        """Returns what was inferred, one parameter a line ("Box = box_a: of 3 that fit, the first by id")."""
        return [f"{key} = {self.values[key]}: {reason}" for key, reason in self.reasons.items()]


@dataclass(frozen=True, slots=True)
class Missing:
    """Required parameters stay open: the module does not run.

    Attributes:
        verdicts: Why nothing was found, by key of each parameter that is missing.
        values: What is specified or was found of the others, by key.
    """

    verdicts: Mapping[str, Verdict]
    values: Mapping[str, Any]

    @property
    def keys(self) -> tuple[str, ...]:
        """The parameters that are missing, in the order in which they are described."""
        return tuple(self.verdicts)

    def __str__(self) -> str:
        said = {"keys": ", ".join(self.keys), "reasons": "; ".join(line.strip() for line in self.lines())}
        if len(self.keys) > 1:
            return Message("parameters {keys} not specified: {reasons}", **said)
        return Message("parameter {keys} not specified: {reasons}", **said)

    def lines(self) -> list[str]:
        """Returns the reasons as indented lines."""
        return [line for verdict in self.verdicts.values() for line in verdict.lines()]


_ENOUGH = 100_000
"""So many combinations are compared; more only arise where nothing connects one parameter with the others."""


def infer(
    description: SkillDescription, given: Mapping[str, Any], view: WorldView, agent: str | None = None
) -> Inferred | Missing:
    """Specifies the required element parameters that are not given, by what the skill needs. Nothing is remembered.

    Elements are looked for that fulfil all needs together (:attr:`SkillDescription.needs`); of several solutions
    :func:`~skiros_py.skills.inference.search.choose` takes one. Where no elements fulfil all needs, those needs are
    put aside, from the first one on, that do not go with the others: a parameter that they speak of is still set where
    only one element is left for it, so that the check of the preconditions can say of this one what does not hold.
    Otherwise it is missing, with the reason. Needs that speak of given parameters only are not looked at here.

    Args:
        description: The skill.
        given: Values by key, as :func:`~skiros_py.skills.parameters.read_arguments` gives them.
        view: The world.
        agent: Who does it, where that is not given.

    Raises:
        UnknownName: A pattern asks for what no ontology or reasoner knows.
        DescriptionError: A plug-in that was asked broke.
    """
    values = {p.key: p.default if given.get(p.key) is None else given[p.key] for p in description.params}
    reasons: dict[str, str] = {}
    if agent is not None and values[description.agent] is None:
        values[description.agent], reasons[description.agent] = agent, Message("it does it")
    verdicts: dict[str, Verdict] = {}
    for group in _groups(description, values):
        found = _solve(group, view)
        values |= found.values
        reasons |= found.reasons
        verdicts |= found.missing
    for key in missing(description.params, values):
        param = description.param(key)
        kind = f"{param.type_name} [{param.unit}]" if param.unit else param.type_name
        verdicts.setdefault(key, Verdict(False, Message("{key}: a {kind} must be given", key=key, kind=kind)))
    if verdicts:
        return Missing({p.key: verdicts[p.key] for p in description.params if p.key in verdicts}, values)
    return Inferred(values, {p.key: reasons[p.key] for p in description.params if p.key in reasons})


def applying(conditions: Iterable[Condition], values: Mapping[str, Any]) -> tuple[Condition, ...]:
    """Returns the conditions that speak of specified parameters only: others are about what the call does without."""

    def specified(condition: Condition) -> bool:
        given = all(values.get(argument) is not None for argument in condition.arguments)
        return given and all(values.get(name, name) is not None for name in condition.names)

    return tuple(filter(specified, conditions))


@dataclass(frozen=True, slots=True)
class _Group:
    """Open parameters that depend on each other, and what they need."""

    params: tuple[Param, ...]
    needs: tuple[Condition, ...]
    known: Mapping[str, str]

    def without(self, params: Sequence[Param]) -> _Group:
        keys = {param.key for param in params}
        needs = tuple(need for need in self.needs if not keys.intersection(need.arguments))
        return _Group(tuple(p for p in self.params if p not in params), needs, self.known)

    def solutions(self, needs: Sequence[Condition], view: WorldView, most: int = _ENOUGH) -> list[Solution]:
        classes = {param.key: param.element_class for param in self.params}
        patterns = [part for need in needs for part in conjuncts(need.pattern)]
        return list(islice(Search(view, classes, patterns, self.known).solutions(), most))


@dataclass(frozen=True, slots=True)
class _Found:
    values: Mapping[str, str]
    reasons: Mapping[str, str]
    missing: Mapping[str, Verdict]


def _groups(description: SkillDescription, values: Mapping[str, Any]) -> list[_Group]:
    """The open parameters, apart where no need and no preference connects them."""
    elements = [param for param in description.params if param.is_element]
    known = {param.key: str(values[param.key]) for param in elements if values[param.key] is not None}
    open_ = [nearest_first(p, description.agent) for p in elements if p.is_inferred and p.key not in known]
    speakable = {*known, *(param.key for param in open_)}
    needs = [need for need in description.needs if speakable.issuperset(need.arguments)]
    preferences = [{p.key, *variables(pattern)} - {IT} for p in open_ for pattern in p.preferred]
    sets = _connected([p.key for p in open_], [*(set(need.arguments) for need in needs), *preferences])
    groups = []
    for keys in sets:
        params = tuple(param for param in open_ if param.key in keys)
        groups.append(_Group(params, tuple(n for n in needs if keys.intersection(n.arguments)), known))
    return groups


def _connected(keys: Sequence[str], links: Iterable[set[str]]) -> list[set[str]]:
    sets = [{key} for key in keys]
    for link in links:
        touched = [one for one in sets if one & link]
        if len(touched) > 1:
            sets = [one for one in sets if one not in touched] + [set().union(*touched)]
    return sets


def _solve(group: _Group, view: WorldView) -> _Found:
    """Chooses by those needs that can hold together; of what the others speak, only one element may be left."""
    solutions = group.solutions(group.needs, view)
    failed: list[Condition] = []
    if not solutions:
        without_any = [param for param in group.params if not view.instances(param.element_class)]
        if without_any:
            there_is_none = {
                p.key: Verdict(False, Message("{key}: there is no {kind}", key=p.key, kind=p.element_class))
                for p in without_any
            }
            others = len(without_any) < len(group.params)
            rest = _solve(group.without(without_any), view) if others else _Found({}, {}, {})
            return _Found(rest.values, rest.reasons, {**rest.missing, **there_is_none})
        kept: list[Condition] = []
        for need in group.needs:
            (kept if group.solutions([*kept, need], view, most=1) else failed).append(need)
        solutions = group.solutions(kept, view)
    best, reasons = choose(group.params, solutions, group.known, view)
    open_: dict[str, Verdict] = {}
    for param in group.params:
        fitting = sorted({solution[param.key] for solution in solutions})
        lacking = [need for need in failed if param.key in need.arguments]
        if len(fitting) > 1 and lacking:
            said = {"key": param.key, "thing": best[param.key], "count": len(fitting)}
            text = Message("{key}: {thing}, the best of {count} candidates", **said)
            verdicts = tuple(need.evaluate(view, {**group.known, **best}) for need in lacking)
            open_[param.key] = Verdict(False, text, verdicts)
        elif len(fitting) > 1 and param.unique:
            listed = f"{', '.join(fitting[:10])}{', …' if len(fitting) > 10 else ''}"
            text = Message("{key}: {things} all fit: say which", key=param.key, things=listed)
            if failed:
                text = Message("{key}: {things} are left: say which", key=param.key, things=listed)
            open_[param.key] = Verdict(False, text)
        elif lacking:
            reasons[param.key] = Message("the only candidate, although {condition} does not hold", condition=lacking[0])
    values = {key: value for key, value in best.items() if key not in open_}
    return _Found(values, {key: reason for key, reason in reasons.items() if key not in open_}, open_)
