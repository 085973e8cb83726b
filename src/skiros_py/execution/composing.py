"""Runs a skill's body: a tree of data becomes a generator of generators.

A successor starts in the cycle after its predecessor's end. A part that is broken off by the composition itself (the
losers of a race, what a guard or a timeout ends) makes up for it before the composition goes on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import closing
from typing import Any

from skiros_py.execution.contained import contained
from skiros_py.execution.scope import Scope, make_up
from skiros_py.skills.composition import (
    AssertEffects,
    Check,
    Do,
    Fallback,
    ForEach,
    Guard,
    Node,
    P,
    Parallel,
    Policy,
    Repeat,
    Retry,
    Sequence,
    Timeout,
    Wait,
)
from skiros_py.skills.conditions import Verdict
from skiros_py.skills.inference import applying
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.primitive import Execution

__all__ = ["run_node", "why"]


def run_node(node: Node, scope: Scope) -> Execution[Outcome]:
    """Returns the run of one node."""
    return _RUNNERS[type(node)](node, scope)


def _do(node: Do, scope: Scope) -> Execution[Outcome]:
    run = contained(node.module, lambda: scope.modules.run(node.module, _values(node.arguments, scope), scope))
    return run if isinstance(run, Failure) else (yield from run)


def _values(arguments: Mapping[str, Any], scope: Scope) -> dict[str, Any]:
    """Fills in the skill's parameters; those that are unspecified stay so in what is called."""
    values = {key: scope.arguments.get(v.key) if isinstance(v, P) else v for key, v in arguments.items()}
    return {key: value for key, value in values.items() if value is not None}


def _sequence(node: Sequence, scope: Scope) -> Execution[Outcome]:
    return _until(node.children, scope, ends_with=Failure)


def _fallback(node: Fallback, scope: Scope) -> Execution[Outcome]:
    return _until(node.children, scope, ends_with=Success)


def _retry(node: Retry, scope: Scope) -> Execution[Outcome]:
    return _until((node.child,) * node.times, scope, ends_with=Success)


def _until(children: Iterable[Node], scope: Scope, *, ends_with: type[Outcome]) -> Execution[Outcome]:
    outcome: Outcome = Success()
    for index, child in enumerate(children):
        if index:
            yield
        outcome = yield from run_node(child, scope)
        if isinstance(outcome, ends_with):
            return outcome
    return outcome


def _repeat(node: Repeat, scope: Scope) -> Execution[Outcome]:
    done = 0
    while True:
        outcome = yield from run_node(node.child, scope)
        done += 1
        if isinstance(outcome, Failure) or done == node.times:
            return outcome
        yield


def _parallel(node: Parallel, scope: Scope) -> Execution[Outcome]:
    policy = node.policy
    if not node.children:
        return Success()
    with scope.apart() as inner:
        branches = [(number, run_node(child, inner)) for number, child in enumerate(node.children)]
        ended: dict[int, Outcome] = {}
        try:
            while True:
                before = len(ended)
                for number, branch in branches:
                    try:
                        next(branch)
                    except StopIteration as end:
                        ended[number] = end.value
                        if _decided(end.value, policy):
                            break
                if len(ended) > before:
                    branches = [(number, branch) for number, branch in branches if number not in ended]
                    if not branches or any(_decided(outcome, policy) for outcome in ended.values()):
                        break
                yield
        finally:
            for _, branch in branches:
                branch.close()
        yield from make_up(inner)
    return _together(ended, policy)


def _decided(outcome: Outcome, policy: Policy) -> bool:
    """Tells whether one ending ends them all."""
    match policy:
        case Policy.FIRST_FAILURE:
            return isinstance(outcome, Failure)
        case Policy.FIRST_SUCCESS:
            return isinstance(outcome, Success)
        case Policy.ALL:
            return False


def _together(ended: Mapping[int, Outcome], policy: Policy) -> Outcome:
    in_order = [ended[number] for number in sorted(ended)]
    good = [outcome for outcome in in_order if isinstance(outcome, Success)]
    bad = [outcome for outcome in in_order if isinstance(outcome, Failure)]
    if policy is Policy.FIRST_SUCCESS:
        return good[0] if good else _all_of(bad)
    return _all_of(bad) if bad else Success("; ".join(o.message for o in good if o.message))


def _all_of(failures: list[Failure]) -> Failure:
    return Failure("; ".join(failure.reason for failure in failures), failures[0].code)


def _timeout(node: Timeout, scope: Scope) -> Execution[Outcome]:
    context, end = scope.context, scope.context.now + node.seconds
    with scope.apart() as inner, closing(run_node(node.child, inner)) as run:
        while True:
            try:
                next(run)
            except StopIteration as ended:
                outcome: Outcome = ended.value
                return outcome
            if context.now >= end - 1e-9:
                break
            yield
        run.close()
        yield from make_up(inner)
    return Failure(f"took longer than {node.seconds:g} s")


def _guard(node: Guard, scope: Scope) -> Execution[Outcome]:
    watch = scope.watches.add(applying(node.conditions, scope.arguments), scope.arguments)
    with closing(watch), scope.apart() as inner, closing(run_node(node.child, inner)) as run:
        while True:
            broken = watch.broken()
            if broken is not None:
                break
            try:
                next(run)
            except StopIteration as ended:
                outcome: Outcome = ended.value
                return outcome
            yield
        run.close()
        yield from make_up(inner)
    return Failure(f"no longer {broken.text}: {why(broken)}")


def _for_each(node: ForEach, scope: Scope) -> Execution[Outcome]:
    world = scope.context.world
    given = {key: value for key, value in scope.arguments.items() if isinstance(value, str)}
    fitting = [
        element
        for element in world.instances(node.class_)
        if node.where is None or node.where.evaluate(world, {**given, node.key: element})
    ]
    outcome: Outcome = Success(f"there is no {node.key}")
    for index, element in enumerate(fitting):
        if index:
            yield
        if not world.has(element):
            continue  # gone meanwhile
        outcome = yield from run_node(node.child, scope.with_arguments({node.key: element}))
        if isinstance(outcome, Failure):
            return Failure(f"{element}: {outcome.reason}", outcome.code)
    return outcome


def _check(node: Check, scope: Scope) -> Execution[Outcome]:
    yield from ()
    for condition in applying(node.conditions, scope.arguments):
        verdict = condition.evaluate(scope.context.world, scope.arguments)
        if not verdict:
            return Failure(f"{verdict.text}: {why(verdict)}")
    return Success()


def why(verdict: Verdict) -> str:
    """Returns the reasons below a verdict, in one line."""
    return "; ".join(line.strip() for line in verdict.lines()[1:])


def _wait(node: Wait, scope: Scope) -> Execution[Outcome]:
    yield from _pass(node.seconds, scope)
    return Success()


def _pretend(node: AssertEffects, scope: Scope) -> Execution[Outcome]:
    yield from _pass(node.seconds, scope)
    effects = scope.context.effects
    if effects is None:
        return Failure("there is no skill here whose effects could be pretended")
    effects.happened(*node.only, author=scope.callers[-1], reason="pretended by a fake")
    return Success("pretended")


def _pass(seconds: float, scope: Scope) -> Execution[None]:
    end = scope.context.now + seconds
    while scope.context.now < end - 1e-9:
        yield


_RUNNERS: Mapping[type, Callable[[Any, Scope], Execution[Outcome]]] = {
    Do: _do,
    Sequence: _sequence,
    Fallback: _fallback,
    Parallel: _parallel,
    Retry: _retry,
    Repeat: _repeat,
    Timeout: _timeout,
    Guard: _guard,
    ForEach: _for_each,
    Check: _check,
    Wait: _wait,
    AssertEffects: _pretend,
}
