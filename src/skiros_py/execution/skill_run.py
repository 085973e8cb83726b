"""One run of a skill (paper Fig. 9): pre-sensing, preconditions, body, postconditions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from skiros_py.execution.body import Scope, run_node
from skiros_py.execution.monitor import ModuleEvent, Monitor, Status
from skiros_py.skills.conditions import Condition, Not, Related
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import BROKEN_OFF, Failure, Outcome, Success
from skiros_py.skills.parameters import Kind
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill
from skiros_py.world.world import World

__all__ = ["SkillRun"]

_RECOVERY_LIMIT = 20.0
"""Longest time for motion after a skill was broken off [s]."""


class SkillRun:
    """Runs one skill with given parameters."""

    def __init__(
        self,
        skill: Skill,
        arguments: Mapping[str, Any],
        context: RunContext,
        primitives: Mapping[str, type[Primitive[Any]]],
        monitor: Monitor,
    ) -> None:
        self.skill = skill
        defaults = {p.key: p.default for p in skill.description.params}
        self.arguments = {**defaults, **arguments}
        self._context = context
        self._monitor = monitor
        self._broken_off = ""
        assert_all = lambda: _assert_effects(context.world, skill, arguments)  # noqa: E731 - a closure, named once
        self._scope = Scope(context, primitives, monitor, self.arguments, assert_all)

    def break_off(self, reason: str) -> None:
        """Ends the body in the coming tick; what must follow (recovery, finishing motion) is done all the same."""
        self._broken_off = reason

    def execute(self) -> Execution[Outcome]:
        """Runs it; also reports to the monitor."""
        self._tell(Status.STARTED, 0, ", ".join(f"{k}={v}" for k, v in self.arguments.items()))
        try:
            outcome = yield from self._phases()
        except GeneratorExit:
            self._tell(Status.PREEMPTED, 0, "stopped")
            raise
        if isinstance(outcome, Failure):
            self._tell(Status.ERROR, outcome.code, outcome.reason)
        else:
            self._tell(Status.TERMINATED, 1, outcome.message)
        return outcome

    def _phases(self) -> Execution[Outcome]:
        description = self.skill.description
        missing = [p.key for p in description.params if p.kind is Kind.ONLINE and self.arguments.get(p.key) is None]
        if missing:
            return Failure(f"parameter {', '.join(missing)} of {description.name} is not specified")
        if self.skill.pre_sense is not None:
            sensed = yield from run_node(self.skill.pre_sense, self._scope)
            if isinstance(sensed, Failure):
                return sensed
            yield
        refusal = self._check("precondition", description.pre)
        if refusal:
            return refusal
        outcome = yield from self._body()
        if self.skill.finish is not None:
            yield
            finished = yield from run_node(self.skill.finish, self._scope)
            outcome = finished if isinstance(finished, Failure) and isinstance(outcome, Success) else outcome
        if isinstance(outcome, Failure):
            return outcome
        return self._check("postcondition", description.post) or outcome

    def _body(self) -> Execution[Outcome]:
        body = run_node(self.skill.body, self._scope)
        checked = -1
        while True:
            fault = Failure(self._broken_off, BROKEN_OFF) if self._broken_off else None
            if self._context.world.version != checked:
                checked = self._context.world.version
                fault = fault or self._check("hold condition", self.skill.description.hold)
            if fault is not None:
                body.close()
                yield from self._recover()
                return fault
            try:
                next(body)
            except StopIteration as end:
                outcome: Outcome = end.value
                return outcome
            yield

    def _recover(self) -> Execution[None]:
        """Ticks what the primitives broken off want to make up for, under a time limit."""
        deadline = self._context.now + _RECOVERY_LIMIT
        for primitive in self._scope.interrupted:
            recovery = primitive.recover()
            for _ in recovery:
                if self._context.now > deadline:
                    recovery.close()
                    return
                yield

    def _check(self, kind: str, conditions: Sequence[Condition]) -> Failure | None:
        for condition in conditions:
            verdict = condition.evaluate(self._context.world, self.arguments)
            if not verdict:
                return Failure(f"{kind} {verdict.text}: {_why(verdict.lines())}")
        return None

    def _tell(self, status: Status, code: int, text: str) -> None:
        description = self.skill.description
        target = str(self.arguments.get(description.target, ""))
        self._monitor.publish(ModuleEvent(self._context.now, "skill", description.name, status, code, text, target))


def _why(lines: Sequence[str]) -> str:
    return "; ".join(line.strip() for line in lines[1:])


def _assert_effects(world: World, skill: Skill, arguments: Mapping[str, Any]) -> None:
    """Writes all postconditions at once: what a fake does instead of sensing."""
    name = skill.description.name
    with world.transaction(author=name, reason="pretended by a fake") as tx:
        for condition in skill.description.post:
            match condition.bind(arguments).pattern:
                case Related(relation, subject, object_) if world.ontology.is_placement(relation):
                    tx.place(subject, relation, object_)
                case Related(relation, subject, object_):
                    tx.relate(subject, relation, object_)
                case Not(Related(relation, subject, object_)) if not world.ontology.is_placement(relation):
                    tx.unrelate(subject, relation, object_)
                case _:
                    pass  # follows from what was moved
