"""One run of a skill (paper Fig. 9): pre-sensing, preconditions, body, post-sensing, postconditions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from typing import Any

from skiros_py.errors import SkirosError
from skiros_py.execution.claims import Claim
from skiros_py.execution.composing import run_node, why
from skiros_py.execution.hardware import complete, devices_of
from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.execution.primitive_run import Take
from skiros_py.execution.scope import Scope, Unfinished, make_up
from skiros_py.skills.composition import Node
from skiros_py.skills.conditions import Condition
from skiros_py.skills.effects import Effects
from skiros_py.skills.inference import Inferred, Missing, infer
from skiros_py.skills.outcome import BROKEN_OFF, Failure, Outcome, Success
from skiros_py.skills.parameters import read_arguments
from skiros_py.skills.primitive import Execution
from skiros_py.skills.skill import Skill, SkillDescription

__all__ = ["SkillRun"]


class SkillRun:
    """Runs one skill: its implementations in turn, until one of them does what the description promises.

    Args:
        implementations: Ways to do it, in the order in which they are tried; all of one description.
        given: Parameters; those left out are inferred when the run starts.
        scope: What it runs in.
        take: Asks for its devices.

    Attributes:
        description: What is promised.
        arguments: The parameters, as far as they are known.
    """

    def __init__(self, implementations: Sequence[Skill], given: Mapping[str, Any], scope: Scope, take: Take) -> None:
        self.description: SkillDescription = implementations[0].description
        self.arguments: dict[str, Any] = {p.key: p.default for p in self.description.params} | dict(given)
        self._implementations = implementations
        self._given = given
        self._outer = scope
        self._take = take
        self._broken_off = ""
        self._finish: Node | None = None
        effects = Effects(scope.context.world, self.description.post, self.arguments)
        self._scope = replace(
            scope,
            context=replace(scope.context, effects=effects),
            arguments=self.arguments,
            unfinished=[],
            callers=(*scope.callers, self.description.name),
        )

    def break_off(self, reason: str) -> None:
        """Ends the body in the coming tick; what must follow (recovery, finishing motion) is done all the same."""
        self._broken_off = reason

    def recover(self) -> Execution[None]:
        """What must follow where the run was broken off by what it is part of."""
        yield from make_up(self._scope)
        if self._finish is not None:
            yield from run_node(self._finish, self._scope)

    def execute(self) -> Execution[Outcome]:
        """Runs it; also reports to the monitor."""
        claim: Claim | None = None
        kept = False
        try:
            found = self._specify()
            outcome: Outcome | None = found if isinstance(found, Failure) else None
            self._tell(Status.STARTED, 0, ", ".join(f"{k}={v}" for k, v in self.arguments.items() if v is not None))
            for line in found.lines() if isinstance(found, Inferred) else ():
                self._tell(Status.RUNNING, 0, line)
            if outcome is None:
                claim = self._take(self.description.name, self._devices(), self._outer.claim)
                while not claim.granted:
                    yield
                self._scope = replace(self._scope, claim=claim)
                outcome = yield from self._attempts()
        except GeneratorExit:
            if claim is not None:
                self._outer.unfinished.append(Unfinished(self.description.name, self.recover, claim))
                kept = True
            nested = bool(self._outer.callers)
            self._tell(*((Status.PREEMPTED, 0, "broken off") if nested else (Status.RUNNING, 0, "stopping")))
            raise
        except SkirosError as error:
            outcome = Failure(f"{self.description.name}: {error}")
        finally:
            if claim is not None and not kept:
                claim.release()
        if isinstance(outcome, Failure):
            self._tell(Status.ERROR, outcome.code, outcome.reason)
        else:
            self._tell(Status.TERMINATED, 1, outcome.message)
        return outcome

    # ------------------------------------------------------------------ parameters and devices

    def _specify(self) -> Inferred | Failure:
        """Fills in what is left out, or returns why that is not possible."""
        world, name = self._scope.context.world, self.description.name
        if len(self._scope.callers) > _DEEPEST:
            return Failure(f"{name}: skills call each other without end: {' > '.join(self._scope.callers[-4:])}")
        try:
            given = read_arguments(self.description.params, self._given, world)
            own = [self.description.param(self.description.agent)]
            found = infer(self.description, complete(world, own, given, self._scope.agent), world)
        except SkirosError as error:
            return Failure(f"{name}: {error}")
        if isinstance(found, Missing):
            return Failure(f"{name}: {found}")
        self.arguments.update(found.values)
        return found

    def _devices(self) -> set[str]:
        takes = [key for skill in self._implementations for key in skill.takes]
        return devices_of(self._scope.context.world, self.description.params, takes, self.arguments)

    # ------------------------------------------------------------------ phases

    def _attempts(self) -> Execution[Outcome]:
        """Tries one implementation after the other, for as long as the preconditions still hold."""
        failures: list[Failure] = []
        for skill in self._implementations:
            if failures:
                yield
                if self._check("precondition", self.description.needs) is not None:
                    break
                self._tell(Status.RUNNING, 0, f"{failures[-1].reason}; trying {_label(skill)}")
            outcome = yield from self._attempt(skill)
            if isinstance(outcome, Success) or outcome.code == BROKEN_OFF:
                return outcome
            failures.append(outcome)
        reasons = dict.fromkeys(failure.reason for failure in failures)
        return Failure("; then ".join(reasons), failures[-1].code)

    def _attempt(self, skill: Skill) -> Execution[Outcome]:
        if skill.pre_sense is not None:
            sensed = yield from run_node(skill.pre_sense, self._scope)
            if isinstance(sensed, Failure):
                return sensed
            yield
        refusal = self._check("precondition", (*self.description.needs, *skill.when))
        if refusal is not None:
            return refusal
        self._finish = skill.finish
        outcome = yield from self._body(skill)
        if skill.finish is not None:
            yield
            finished = yield from run_node(skill.finish, self._scope)
            self._finish = None
            outcome = finished if isinstance(finished, Failure) and isinstance(outcome, Success) else outcome
        if isinstance(outcome, Success) and skill.post_sense is not None:
            yield
            sensed = yield from run_node(skill.post_sense, self._scope)
            outcome = sensed if isinstance(sensed, Failure) else outcome
        if isinstance(outcome, Failure):
            return outcome
        return self._check("postcondition", self.description.post) or outcome

    def _body(self, skill: Skill) -> Execution[Outcome]:
        watch = self._scope.watches.add(self.description.hold, self.arguments)
        with closing(watch), closing(run_node(skill.body, self._scope)) as body:
            while True:
                fault = self._fault(watch.broken)
                if fault is not None:
                    break
                try:
                    next(body)
                except StopIteration as end:
                    outcome: Outcome = end.value
                    return outcome
                yield
            body.close()
            yield from make_up(self._scope)
        return fault

    def _fault(self, broken: Any) -> Failure | None:
        if self._broken_off:
            return Failure(self._broken_off, BROKEN_OFF)
        verdict = broken()
        return None if verdict is None else Failure(f"hold condition {verdict.text}: {why(verdict)}")

    def _check(self, kind: str, conditions: Sequence[Condition]) -> Failure | None:
        for condition in conditions:
            verdict = condition.evaluate(self._scope.context.world, self.arguments)
            if not verdict:
                return Failure(f"{kind} {verdict.text}: {why(verdict)}")
        return None

    def _tell(self, status: Status, code: int, text: str) -> None:
        target = str(self.arguments.get(self.description.target) or "")
        caller = self._outer.callers[-1] if self._outer.callers else ""
        time, agent = self._scope.context.board.snapshot.time, self._scope.agent
        event = ModuleEvent(time, "skill", self.description.name, status, code, text, target, agent, caller)
        self._scope.monitor.publish(event)


_DEEPEST = 20
"""Skills within skills: more than these are taken for a circle."""


def _label(skill: Skill) -> str:
    return skill.label or f"implementation {skill.version}"
