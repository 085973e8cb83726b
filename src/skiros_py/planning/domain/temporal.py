"""A task in time: the same PDDL with durative actions (PDDL 2.1), for planners that support concurrency.

Nothing is said again: each action of a skill is rewritten. Preconditions must hold at the start; those that the action
does not delete itself must hold throughout. Deletes happen at the start, adds at the end. An agent does one thing at a
time. Bookkeeping takes no time and is unchanged.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from skiros_py.planning.domain.bracketed import (
    Term,
    block,
    conjuncts,
    field,
    read_term,
    shown,
    typed_lines,
    unused,
    words,
)
from skiros_py.planning.domain.model import Action
from skiros_py.planning.domain.pddl import PddlTexts, write_pddl
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.robots.allocation import USUAL

Rates = Mapping[str, Mapping[str, float]]
"""Durations of skills [s], by skill and agent."""


def write_temporal(task: PlanningTask, *, name: str, rates: Rates | None = None) -> PddlTexts:
    """Writes a task with durative actions; a skill of unknown duration gets the default.

    Args:
        task: The task; see :func:`~skiros_py.planning.durations.timed`.
        name: Name of the problem (made a PDDL name).
        rates: The durations per agent: if they differ, the duration is a function of the agent
            (``:numeric-fluents``).
    """
    texts = write_pddl(task.domain, task.problem, name=name)
    differing = {skill: own for skill, own in (rates or {}).items() if len(set(own.values())) > 1}
    numeric = (":numeric-fluents",) if differing else ()
    requirements = (*texts.requirements, ":durative-actions", *numeric)
    agents = {c.skill.name: f"?{c.skill.agent}" for c in task.capabilities}
    domain = _Rewriting(texts, agents, requirements, differing)
    facts = [f"({domain.idle} {texts.objects.pddl(agent)})" for agent in domain.agents(task)]
    for skill in sorted(domain.functions):
        own = differing[skill]
        known = sorted(own.keys() & task.problem.objects.keys())
        facts += [f"(= ({domain.functions[skill]} {texts.objects.pddl(a)}) {own[a]:.3f})" for a in known]
    problem = texts.problem.replace("(:init\n", "(:init\n" + "".join(f"    {fact}\n" for fact in facts), 1)
    return replace(texts, domain=domain.text(), problem=problem, requirements=requirements)


class _Rewriting:
    """A domain, being made durative.

    Attributes:
        idle: The predicate stating that an agent is idle.
        functions: The duration function, by skill, if agents differ.
    """

    def __init__(
        self, texts: PddlTexts, agents: Mapping[str, str], requirements: Sequence[str], differing: Iterable[str]
    ) -> None:
        self._texts = texts
        self._agents = agents
        self._requirements = requirements
        self._whole = read_term(texts.domain)
        self.idle = unused("idle", texts.domain + texts.problem)
        words_of = {action.skill: name for name, action in reversed([*texts.actions.items()]) if action.skill}
        self.functions = {s: unused(f"{words_of[s]}_time", texts.domain) for s in differing if s in words_of}
        self._changing = {words[0] for part in _parts(self._whole) for words in _effects(part)}

    def agents(self, task: PlanningTask) -> list[str]:
        """The agents that act in the task."""
        acting = {action.skill for action in self._texts.actions.values()}
        found = {agent for c in task.capabilities if c.skill.name in acting for agent in c.agents}
        return sorted(found & task.problem.objects.keys())

    def text(self) -> str:
        """The domain text."""
        lines = ["(" + " ".join(map(shown, self._whole[:2]))]
        for part in self._whole[2:]:
            lines += self._part(part)
        return "\n".join([*lines, ")"]) + "\n"

    def _part(self, part: Term) -> list[str]:
        match part:
            case [":requirements", *_]:
                return [f"  (:requirements {' '.join(self._requirements)})"]
            case [":predicates", *predicates]:
                own = [f"({self.idle} ?x1 - object)", *map(shown, predicates)]
                timing = [f"    ({function} ?x1 - object) - number" for _, function in sorted(self.functions.items())]
                functions = ["  (:functions", *timing, "  )"] if timing else []
                return ["  (:predicates", *(f"    {line}" for line in own), "  )", *functions]
            case [":action", str(name), *_] if self._texts.actions[name].skill is not None:
                return self._durative(self._texts.actions[name], name, part)
            case [":types" | ":constants" as keyword, *terms]:
                return [f"  ({keyword}", *(f"    {line}" for line in typed_lines(terms)), "  )"]
            case _:
                return [f"  {shown(part)}"]

    def _durative(self, action: Action, name: str, part: Sequence[Term]) -> list[str]:
        agent = self._variable(action, part)
        needed = conjuncts(field(part, ":precondition"))
        effects = conjuncts(field(part, ":effect"))
        gone = [effect[1] for effect in effects if effect[0] == "not"]
        lasting = [c for c in needed if c not in gone and self._may_change(c)]
        conditions = [f"(at start ({self.idle} {agent}))", *(f"(at start {shown(c)})" for c in needed)]
        conditions += [f"(over all {shown(c)})" for c in lasting]
        results = [f"(at start (not ({self.idle} {agent})))", *(f"(at start (not {shown(g)}))" for g in gone)]
        results += [f"(at end {shown(e)})" for e in effects if e[0] != "not"] + [f"(at end ({self.idle} {agent}))"]
        return [
            f"  (:durative-action {name}",
            f"    :parameters {shown(field(part, ':parameters'))}",
            f"    :duration (= ?duration {self._duration(action, agent)})",
            block(":condition", conditions),
            block(":effect", results) + ")",
        ]

    def _duration(self, action: Action, agent: str) -> str:
        if action.skill in self.functions:
            return f"({self.functions[action.skill]} {agent})"
        return f"{USUAL if action.duration is None else action.duration:.3f}"

    def _variable(self, action: Action, part: Sequence[Term]) -> str:
        """The PDDL name of the parameter that is the agent."""
        variables = [str(term) for term in field(part, ":parameters") if str(term).startswith("?")]
        at = [variable.name for variable in action.parameters].index(self._agents[str(action.skill)])
        return variables[at]

    def _may_change(self, condition: Term) -> bool:
        return not self._changing.isdisjoint(words(condition))


def _parts(domain: Sequence[Term]) -> Iterator[list[Term]]:
    return (part for part in domain if isinstance(part, list) and part[0] == ":action")


def _effects(action: Sequence[Term]) -> Iterator[list[str]]:
    """The words of every atom that an action writes."""
    for effect in conjuncts(field(action, ":effect")):
        yield list(words(effect[1] if effect[0] == "not" else effect))
