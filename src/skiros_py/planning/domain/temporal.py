"""A task in time: the same PDDL with durative actions (PDDL 2.1), for planners that support concurrency.

Preconditions of a skill must hold at the start; those that the action does not delete itself must hold throughout.
Deletes happen at the start, adds at the end; so numbers fall at the start and grow at the end. What is asked of a
number must hold at the start. An agent does one thing at a time. Bookkeeping takes no time.
"""

from __future__ import annotations

from skiros_py.planning.domain.model import Action
from skiros_py.planning.domain.numbers import DECREASE
from skiros_py.planning.domain.pddl import LEARNED_COST, PddlTexts, PddlWriter, block, real_deletes, variable_names
from skiros_py.planning.experience import cost_table
from skiros_py.planning.problem.reachability import USUAL
from skiros_py.planning.problem.task import PlanningTask


def write_temporal(task: PlanningTask, *, name: str) -> PddlTexts:
    """Writes a task with durative actions; a skill of unknown duration gets the default.

    Args:
        task: The task; see :func:`~skiros_py.planning.experience.timed`.
        name: Name of the problem (made a PDDL name).
    """
    return _TemporalWriter(task, name).texts()


class _TemporalWriter(PddlWriter):
    def __init__(self, task: PlanningTask, name: str) -> None:
        super().__init__(task.domain, task.problem, name)
        self._task = task
        self._idle = self.other_names.pddl("idle")
        self._agents = {c.skill.name: f"?{c.skill.agent}" for c in task.capabilities}
        actions = task.domain.actions
        self._tables = {action.name: table for action in actions if (table := cost_table(task, action))}
        self._times = {action: self.other_names.pddl(f"{LEARNED_COST}-{action}") for action in self._tables}
        self._changing = {atom.predicate for action in actions for atom in (*action.add, *real_deletes(action))}

    def requirements(self) -> tuple[str, ...]:
        known = super().requirements()
        learned = (":numeric-fluents",) if self._tables and ":numeric-fluents" not in known else ()
        return (*known, *learned, ":durative-actions")

    def functions(self) -> list[str]:
        arguments = {name: self.columns(variables) for name, (variables, _) in self._tables.items()}
        return [*(f"({self._times[name]} {said}) - number" for name, said in arguments.items()), *super().functions()]

    def predicate_lines(self) -> list[str]:
        return [f"({self._idle} ?x1 - object)", *super().predicate_lines()]

    def init(self) -> list[str]:
        acting = {action.skill for action in self.domain.actions}
        agents = {agent for c in self._task.capabilities if c.skill.name in acting for agent in c.agents}
        idle = sorted(agents & self.problem.objects.keys())
        learned = [
            f"(= {self.applied(self._times[name], elements)} {seconds:.3f})"
            for name, (_, times) in self._tables.items()
            for elements, seconds in times.items()
        ]
        return [*(f"({self._idle} {self.objects.pddl(agent)})" for agent in idle), *super().init(), *learned]

    def action(self, action: Action) -> str:
        if action.skill is None:
            return super().action(action)
        names = variable_names(action)
        idle = f"({self._idle} ?{names.pddl(self._agents[action.skill])})"
        gone = [self.atom(atom, names) for atom in self.facts(real_deletes(action))]
        lasting = [self.atom(a, names) for a in self.facts(action.pre) if a.predicate in self._changing]
        lasting += [
            self.none(none, names) for none in action.none if any(a.predicate in self._changing for a in none.atoms)
        ]
        conditions = [f"(at start {c})" for c in (idle, *self.needs(action, names))]
        conditions += [f"(over all {c})" for c in lasting if c not in gone]
        effects = [f"(at start (not {c}))" for c in (idle, *gone)]
        effects += [f"(at end {c})" for c in (*(self.atom(atom, names) for atom in self.facts(action.add)), idle)]
        when = {DECREASE: "start"}
        effects += [f"(at {when.get(word, 'end')} {change})" for word, change in self.changes(action, names)]
        seconds = action.duration if action.costs is None else action.seconds({})
        lasts = f"{USUAL if seconds is None else seconds:.3f}"
        if action.name in self._tables:
            lasts = self.applied(self._times[action.name], self._tables[action.name][0], names)
        return "\n".join(
            [
                f"  (:durative-action {self.actions.pddl(action.name)}",
                f"    :parameters ({self.typed(action.parameters, names)})",
                f"    :duration (= ?duration {lasts})",
                f"    :condition {block(conditions)}",
                f"    :effect {block(effects)})",
            ]
        )
