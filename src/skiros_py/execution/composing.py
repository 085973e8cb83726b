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
from skiros_py.skills.conditions.watch import Watch
from skiros_py.skills.execution import Execution, tick
from skiros_py.skills.inference import applying
from skiros_py.skills.outcome import Failure, Outcome, Success

__all__ = ["lost", "run_node", "run_until"]


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
    ended: dict[int, Outcome] = {}
    with scope.apart() as inner:
        branches = {number: run_node(child, inner) for number, child in enumerate(node.children)}
        try:
            while not _all_over(branches, ended, node.policy):
                yield
        finally:
            for branch in branches.values():
                branch.close()
        yield from make_up(inner)
    return _together(ended, node.policy)


def _all_over(branches: dict[int, Execution[Outcome]], ended: dict[int, Outcome], policy: Policy) -> bool:
    """Ticks the branches in turn and sorts out those that end; returns whether that decides it."""
    for number, branch in tuple(branches.items()):
        outcome = tick(branch)
        if outcome is not None:
            ended[number] = outcome
            del branches[number]
            if _decided(outcome, policy):
                return True
    return not branches


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

    def late() -> Failure | None:
        return Failure(f"took longer than {node.seconds:g} s") if context.now >= end - 1e-9 else None

    return run_until(node.child, scope, lambda run: tick(run) or late())


def _guard(node: Guard, scope: Scope) -> Execution[Outcome]:
    watch = scope.watches.add(applying(node.conditions, scope.arguments), scope.arguments)
    with closing(watch):
        return (yield from run_until(node.child, scope, lambda run: lost(watch, "no longer") or tick(run)))


def lost(watch: Watch, what: str) -> Failure | None:
    """Returns that a watched condition holds no longer; what it is to whoever watches comes first."""
    broken = watch.broken()
    return None if broken is None else Failure(f"{what} {broken.sentence}")


def run_until(node: Node, scope: Scope, end: Callable[[Execution[Outcome]], Outcome | None]) -> Execution[Outcome]:
    """Runs a node until it ends or is ended; then makes up for what was broken off.

    Args:
        node: What is run.
        scope: What it runs in.
        end: Called each cycle: ticks the node's run, or ends it; returns how it ended, None while it goes on.
    """
    with scope.apart() as inner, closing(run_node(node, inner)) as run:
        while True:
            outcome = end(run)
            if outcome is not None:
                break
            yield
        run.close()
        yield from make_up(inner)
    return outcome


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
            return Failure(verdict.sentence)
    return Success()


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
