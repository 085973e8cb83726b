"""One run of a skill (paper Fig. 9): pre-sensing, preconditions, body, post-sensing, postconditions."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from functools import partial
from math import inf
from typing import Any

from skiros_py.behaviours.children import lost, run_until
from skiros_py.execution.claims import Claim, complete, devices_of
from skiros_py.execution.module_faults import contained
from skiros_py.execution.monitor import Status
from skiros_py.execution.panel import ConditionRow
from skiros_py.execution.primitive_run import Take
from skiros_py.execution.scope import ModuleRun, Scope, Unfinished
from skiros_py.execution.time_limit import TimeLimit
from skiros_py.messages import Message, joined
from skiros_py.skills.behaviour import Behaviour
from skiros_py.skills.conditions import Condition, Verdict
from skiros_py.skills.context import Effects
from skiros_py.skills.inference.inferring import Inferred, Missing, applying, infer
from skiros_py.skills.outcome import CANCELLED, Execution, Failure, Outcome, Success
from skiros_py.skills.parameters import read_arguments
from skiros_py.skills.parameters.values import as_shown
from skiros_py.skills.skill import Skill, SkillDescription


class SkillRun(ModuleRun):
    """Runs one skill: its implementations in turn, until one of them does what the description promises.

    Args:
        implementations: Ways to do it, in the order in which they are tried; all of one description.
        given: Parameters; those left out are inferred when the run starts.
        scope: What it runs in.
        take: Asks for its devices.
        run: Id of this run; a new one where left out.

    Attributes:
        description: What is promised.
    """

    def __init__(
        self, implementations: Sequence[Skill], given: Mapping[str, Any], scope: Scope, take: Take, run: str = ""
    ) -> None:
        self.description: SkillDescription = implementations[0].description
        self.arguments: dict[str, Any] = {p.key: p.default for p in self.description.params} | dict(given)
        super().__init__("skill", self.description.name, self.arguments, scope, run)
        self._implementations = implementations
        self._given = given
        self._take = take
        self._cancelled = ""
        self._finish: Behaviour | None = None
        self._limit: TimeLimit | None = None
        self._found: dict[tuple[str, str], ConditionRow] = {}
        self._way: Skill | None = None
        effects = Effects(scope.context.world, self.description.post, self.arguments)
        values: dict[str, Any] = {}
        context = replace(scope.context, effects=effects, questions=scope.context.questions.within())
        self._scope = self.inner_scope(context=context, arguments=ChainMap(self.arguments, values), values=values)

    def cancel(self, reason: str) -> bool:
        """Ends it in the coming tick; what must follow (recovery, finishing motion) is done all the same."""
        self._cancelled = reason
        return True

    def account(self) -> dict[str, Any]:
        """Returns how it was done, with what, and what was found last of its conditions, as plain data."""
        params = self.description.params
        return {
            "inputs": {p.key: as_shown(p, self.arguments.get(p.key)) for p in params},
            "conditions": [row.as_json() for row in self._found.values()],
            "implementation": self.implementation,
        }

    def recover(self) -> Execution[None]:
        """What must follow where the run was cancelled by what it is part of."""
        yield from self._scope.recover()
        if self._finish is not None:
            yield from self._part("finish", self._finish, at_any_rate=True)

    def run(self) -> Execution[Outcome]:
        """Infers what is left out, then does it."""
        found = contained(self.name, self._specify)
        self.started = True
        self._way = None if isinstance(found, Failure) else self._implementations[0]
        self.tell(Status.STARTED, 0, ", ".join(f"{k}={v}" for k, v in self.arguments.items() if v is not None))
        for line in found.lines() if isinstance(found, Inferred) else ():
            self.tell(Status.RUNNING, 0, line)
        return found if isinstance(found, Failure) else (yield from self._attempts())

    def leave(self) -> bool:
        """Ends it at once; returns whether it keeps its devices to recover."""
        if self._claim is None or not self._claim.granted:
            return False
        self._outer.unfinished.append(Unfinished(self.name, self.recover, self._claim))
        return True

    # ------------------------------------------------------------------ parameters and devices

    def _specify(self) -> Inferred | Failure:
        """Fills in what is left out, or returns why that is not possible."""
        world = self._scope.context.world
        self._outer.check_depth(self.name)
        given = read_arguments(self.description.params, self._given, world)
        own = [self.description.param(self.description.agent)]
        found = infer(self.description, complete(world, own, given, self._scope.agent), world)
        if isinstance(found, Missing):
            return Failure(joined(": ", (self.name, str(found))))
        self.arguments.update(found.values)
        return found

    def _with_devices(self, skill: Skill) -> Execution[Outcome]:
        """Tries one implementation with the devices that it takes."""
        name, world = self.name, self._scope.context.world
        self._limit = None  # that of the attempt before; to wait for devices does not count
        devices = devices_of(world, self.description.params, skill.takes, self.arguments)
        claim = contained(name, lambda: self._take(name, devices, self._outer.claim))
        if isinstance(claim, Failure):
            return claim
        self._claim = claim
        self._scope = replace(self._scope, claim=claim)
        outcome = (yield from self._granted(claim)) or (yield from self._attempt(skill))
        claim.release()
        return outcome

    def _granted(self, claim: Claim) -> Execution[Failure | None]:
        """Waits for its devices, or until it is cancelled."""
        if not claim.granted:
            self.tell(Status.RUNNING, 0, Message("waits for {devices}", devices=", ".join(claim.waits_for())))
        while not claim.granted and not self._cancelled:
            yield
        return self._interruption()

    # ------------------------------------------------------------------ phases

    def _attempts(self) -> Execution[Outcome]:
        """Tries one implementation after the other, for as long as the preconditions still hold."""
        failures: list[Failure] = []
        for skill in self._implementations:
            if failures:
                yield
                if self._check(Message("precondition"), self.description.needs) is not None:
                    break
                self._way = skill
                self.tell(
                    Status.RUNNING,
                    0,
                    Message("{reason}; trying {skill}", reason=failures[-1].reason, skill=_label(skill)),
                )
            outcome = yield from self._with_devices(skill)
            if isinstance(outcome, Success) or outcome.code == CANCELLED:
                return outcome
            failures.append(outcome)
        reasons = dict.fromkeys(failure.reason for failure in failures)
        return replace(failures[-1], reason=joined("; ", reasons))

    def _attempt(self, skill: Skill) -> Execution[Outcome]:
        duration, limit = self.description.duration, self.description.limit
        # what makes no progress is one of its primitives, which has a limit of its own
        self._limit = TimeLimit(self._scope.context, duration, inf if duration is limit is None else limit)
        if skill.pre_sense is not None:
            sensed = yield from self._part("pre_sense", skill.pre_sense)
            if isinstance(sensed, Failure):
                return sensed
            yield
        refusal = self._interruption() or self._check(Message("precondition"), (*self.description.needs, *skill.when))
        if refusal is not None:
            return refusal
        self._finish = skill.finish
        outcome = yield from self._part("body", skill.body, self.description.hold)
        if skill.finish is not None:
            yield
            finished = yield from self._part("finish", skill.finish, at_any_rate=True)
            self._finish = None
            outcome = finished if isinstance(finished, Failure) and isinstance(outcome, Success) else outcome
        if isinstance(outcome, Success) and skill.post_sense is not None:
            yield
            sensed = yield from self._part("post_sense", skill.post_sense)
            outcome = sensed if isinstance(sensed, Failure) else outcome
        if isinstance(outcome, Failure):
            return outcome
        return self._check(Message("postcondition"), self.description.post) or outcome

    def _part(
        self, key: str, node: Behaviour, hold: Sequence[Condition] = (), *, at_any_rate: bool = False
    ) -> Execution[Outcome]:
        """Runs a part while conditions hold and the skill is not cancelled; then runs the recovery of what was."""
        watch = self._scope.watches.add(applying(hold, self.arguments), self.arguments)

        def end(run: Execution[Outcome]) -> Outcome | None:
            interruption = None if at_any_rate else self._interruption()
            return (
                interruption or contained(self.name, lambda: lost(watch, Message("hold condition"))) or self.tick(run)
            )

        with closing(watch):
            outcome = yield from run_until(node, key, self._scope, end)
        for condition, verdict in watch.found:
            self._note("hold", condition, verdict)
        return outcome

    def _interruption(self) -> Failure | None:
        if self._cancelled:
            return Failure(self._cancelled, CANCELLED)
        why = self._limit.why_over() if self._limit is not None else ""
        return Failure(joined(" ", (self.name, why))) if why else None

    def _check(self, kind: str, conditions: Sequence[Condition]) -> Failure | None:
        world = self._scope.context.world
        for condition in applying(conditions, self.arguments):
            verdict = contained(self.name, partial(condition.evaluate, world, self.arguments))
            if isinstance(verdict, Failure):
                return verdict
            self._note(kind.removesuffix("condition"), condition, verdict)
            if not verdict:
                return Failure(joined(" ", (kind, verdict.sentence)))
        return None

    def _note(self, kind: str, condition: Condition, verdict: Verdict) -> None:
        """Keeps what was found of a condition; what is looked at again counts as it was found last."""
        self._found[kind, str(condition)] = ConditionRow(kind, str(condition), verdict)

    @property
    def target(self) -> str:
        """Id of the element that it is done to, as far as that is known."""
        return str(self.arguments.get(self.description.target) or "")

    @property
    def implementation(self) -> str | None:
        """Label of the implementation that is tried, as far as that is known."""
        return None if self._way is None else self._way.label


def _label(skill: Skill) -> str:
    return skill.label or f"implementation {skill.version}"
