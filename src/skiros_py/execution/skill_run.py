"""One run of a skill (paper Fig. 9): pre-sensing, preconditions, body, post-sensing, postconditions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from functools import partial
from typing import Any

from skiros_py.execution.claims import Claim
from skiros_py.execution.composing import run_node, why
from skiros_py.execution.contained import contained
from skiros_py.execution.hardware import complete, devices_of
from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.execution.primitive_run import Take
from skiros_py.execution.pulse import CycleOverrun
from skiros_py.execution.scope import Scope, Unfinished, make_up
from skiros_py.skills.composition import Node
from skiros_py.skills.conditions import Condition
from skiros_py.skills.conditions.watch import Watch
from skiros_py.skills.effects import Effects
from skiros_py.skills.inference import Inferred, Missing, applying, infer
from skiros_py.skills.outcome import BROKEN, BROKEN_OFF, Failure, Outcome, Success
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
        self._claim: Claim | None = None
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
        """Ends it in the coming tick; what must follow (recovery, finishing motion) is done all the same."""
        self._broken_off = reason

    def recover(self) -> Execution[None]:
        """What must follow where the run was broken off by what it is part of."""
        yield from make_up(self._scope)
        if self._finish is not None:
            yield from self._part(self._finish, at_any_rate=True)

    def execute(self) -> Execution[Outcome]:
        """Runs it; also reports to the monitor."""
        kept = False
        try:
            outcome = yield from self._run()
        except GeneratorExit:
            kept = self._leave()
            raise
        except CycleOverrun:
            if self._outer.callers:  # else whoever started it tells, when all stands
                self._tell(Status.ERROR, BROKEN, "held the control cycle too long")
            raise
        finally:
            if self._claim is not None and not kept:
                self._claim.release()
        if isinstance(outcome, Failure):
            self._tell(Status.ERROR, outcome.code, outcome.reason)
        else:
            self._tell(Status.TERMINATED, 1, outcome.message)
        return outcome

    def _run(self) -> Execution[Outcome]:
        name = self.description.name
        found = contained(name, self._specify)
        self._tell(Status.STARTED, 0, ", ".join(f"{k}={v}" for k, v in self.arguments.items() if v is not None))
        for line in found.lines() if isinstance(found, Inferred) else ():
            self._tell(Status.RUNNING, 0, line)
        if isinstance(found, Failure):
            return found
        claim = contained(name, lambda: self._take(name, self._devices(), self._outer.claim))
        if isinstance(claim, Failure):
            return claim
        self._claim = claim
        refusal = yield from self._granted(claim)
        self._scope = replace(self._scope, claim=claim)
        return refusal or (yield from self._attempts())

    def _granted(self, claim: Claim) -> Execution[Failure | None]:
        """Waits for its devices, or until it is broken off."""
        if not claim.granted:
            self._tell(Status.RUNNING, 0, f"waits for {', '.join(claim.waits_for())}")
        while not claim.granted and not self._broken_off:
            yield
        return self._interruption()

    def _leave(self) -> bool:
        """Ends it at once; returns whether it keeps its devices to make up for that."""
        if self._claim is not None:
            self._outer.unfinished.append(Unfinished(self.description.name, self.recover, self._claim))
        nested = bool(self._outer.callers)
        self._tell(*((Status.PREEMPTED, 0, "broken off") if nested else (Status.RUNNING, 0, "stopping")))
        return self._claim is not None

    # ------------------------------------------------------------------ parameters and devices

    def _specify(self) -> Inferred | Failure:
        """Fills in what is left out, or returns why that is not possible."""
        world, name = self._scope.context.world, self.description.name
        if len(self._scope.callers) > _DEEPEST:
            return Failure(f"{name}: skills call each other without end: {' > '.join(self._scope.callers[-4:])}")
        given = read_arguments(self.description.params, self._given, world)
        own = [self.description.param(self.description.agent)]
        found = infer(self.description, complete(world, own, given, self._scope.agent), world)
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
            sensed = yield from self._part(skill.pre_sense)
            if isinstance(sensed, Failure):
                return sensed
            yield
        refusal = self._interruption() or self._check("precondition", (*self.description.needs, *skill.when))
        if refusal is not None:
            return refusal
        self._finish = skill.finish
        outcome = yield from self._part(skill.body, self.description.hold)
        if skill.finish is not None:
            yield
            finished = yield from self._part(skill.finish, at_any_rate=True)
            self._finish = None
            outcome = finished if isinstance(finished, Failure) and isinstance(outcome, Success) else outcome
        if isinstance(outcome, Success) and skill.post_sense is not None:
            yield
            sensed = yield from self._part(skill.post_sense)
            outcome = sensed if isinstance(sensed, Failure) else outcome
        if isinstance(outcome, Failure):
            return outcome
        return self._check("postcondition", self.description.post) or outcome

    def _part(self, node: Node, hold: Sequence[Condition] = (), *, at_any_rate: bool = False) -> Execution[Outcome]:
        """Runs a part while conditions hold and nobody breaks the skill off; then makes up for what is open."""
        name = self.description.name
        watch = self._scope.watches.add(applying(hold, self.arguments), self.arguments)
        with closing(watch), closing(run_node(node, self._scope)) as part:
            while True:
                ended: Outcome | None = None if at_any_rate else self._interruption()
                ended = ended or contained(name, lambda: _lost(watch)) or contained(name, lambda: _tick(part))
                if ended is not None:
                    break
                yield
            part.close()
            yield from make_up(self._scope)
        return ended

    def _interruption(self) -> Failure | None:
        return Failure(self._broken_off, BROKEN_OFF) if self._broken_off else None

    def _check(self, kind: str, conditions: Sequence[Condition]) -> Failure | None:
        world = self._scope.context.world
        for condition in applying(conditions, self.arguments):
            verdict = contained(self.description.name, partial(condition.evaluate, world, self.arguments))
            if isinstance(verdict, Failure):
                return verdict
            if not verdict:
                return Failure(f"{kind} {verdict.text}: {why(verdict)}")
        return None

    def _tell(self, status: Status, code: int, text: str) -> None:
        target = str(self.arguments.get(self.description.target) or "")
        caller = self._outer.callers[-1] if self._outer.callers else ""
        time, agent = self._scope.context.board.snapshot.time, self._scope.agent
        event = ModuleEvent(time, "skill", self.description.name, status, code, text, target, agent, caller)
        self._scope.monitor.publish(event)


def _lost(watch: Watch) -> Failure | None:
    """Returns why a hold condition holds no longer."""
    broken = watch.broken()
    return None if broken is None else Failure(f"hold condition {broken.text}: {why(broken)}")


def _tick(run: Execution[Outcome]) -> Outcome | None:
    """Runs up to the next ``yield``; returns how it ended, None while it goes on."""
    try:
        next(run)
    except StopIteration as end:
        outcome: Outcome = end.value
        return outcome
    return None


_DEEPEST = 20
"""Skills within skills: more than these are taken for a circle."""


def _label(skill: Skill) -> str:
    return skill.label or f"implementation {skill.version}"
