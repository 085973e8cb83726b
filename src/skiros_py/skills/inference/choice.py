"""Which of several solutions is taken: what is preferred, of that what costs least, of that the first by id.

Where several parameters have a preference, the one described first counts first; so it is with costs and ids. Ids are
in the order of the world's own answers, that of their characters: ``ball_10`` comes before ``ball_2``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from skiros_py.errors import DescriptionError, SkirosError
from skiros_py.skills.conditions import Binding, Pattern
from skiros_py.skills.inference.narrowing import that_fit
from skiros_py.skills.parameters import IT, Param
from skiros_py.skills.references import variables
from skiros_py.world.names import local_name
from skiros_py.world.view import WorldView

Solution = Mapping[str, str]
"""Element by key, of the parameters that are chosen together."""


def choose(
    params: Sequence[Param], solutions: Sequence[Solution], known: Binding, view: WorldView
) -> tuple[Solution, dict[str, str]]:
    """Returns the best solution, and for each parameter why it is that one.

    Args:
        params: The parameters that are chosen together, in the order in which they are described.
        solutions: At least one.
        known: What is bound already.
        view: The world.

    Raises:
        DescriptionError: An author's cost function broke.
    """
    why: dict[str, list[str]] = {param.key: [] for param in params}
    best = solutions
    for narrow in (_most_preferred, _cheapest):
        for param in params:
            kept, reason = narrow(param, best, known, view)
            if len(kept) < len(best):
                why[param.key].append(reason)
            best = kept
    chosen = min(best, key=lambda solution: tuple(solution[param.key] for param in params))
    return chosen, {param.key: _reason(param, solutions, best, why[param.key]) for param in params}


def _reason(param: Param, solutions: Sequence[Solution], best: Sequence[Solution], why: Sequence[str]) -> str:
    fitting = len({solution[param.key] for solution in solutions})
    if fitting == 1:
        return "the only one that fits"
    several = len({solution[param.key] for solution in best}) > 1
    how = [*why, "the first by id"] if several else why or ["the one that goes with the rest"]
    return f"of {fitting} that fit, {', '.join(how)}"


def _most_preferred(
    param: Param, solutions: Sequence[Solution], known: Binding, view: WorldView
) -> tuple[Sequence[Solution], str]:
    for pattern in param.preferred:
        own = pattern.rename({IT: param.key})
        kept = _fulfilling(own, param.key, solutions, known, view)
        if kept:
            return kept, f"preferred: {own.evaluate(view, {**known, **kept[0]}).text}"
    return solutions, ""


def _fulfilling(
    pattern: Pattern, key: str, solutions: Sequence[Solution], known: Binding, view: WorldView
) -> list[Solution]:
    """Those solutions for which a pattern holds; asked for many candidates together where the rest is the same."""
    others = [name for name in variables(pattern) if name != key]
    if any(name not in known and name not in solutions[0] for name in others):
        return []  # it speaks of an optional parameter that is left open
    groups: dict[tuple[str, ...], list[Solution]] = {}
    for solution in solutions:
        groups.setdefault(tuple(solution[n] for n in others if n in solution), []).append(solution)
    held: set[int] = set()
    for group in groups.values():
        values = tuple(dict.fromkeys(solution[key] for solution in group))
        fits = frozenset(that_fit(pattern, key, values, {**known, **group[0]}, view))
        held.update(id(solution) for solution in group if solution[key] in fits)
    return [solution for solution in solutions if id(solution) in held]


def _cheapest(
    param: Param,
    solutions: Sequence[Solution],
    known: Binding,  # noqa: ARG001 - as of preferences
    view: WorldView,
) -> tuple[Sequence[Solution], str]:
    cost = param.cost
    if cost is None:
        return solutions, ""
    costs = {value: _cost(param, value, view) for value in dict.fromkeys(s[param.key] for s in solutions)}
    least = min(costs.values())
    what = f"{local_name(cost)}" if isinstance(cost, str) else "cost"
    return [s for s in solutions if costs[s[param.key]] == least], f"the one of least {what} ({least:g})"


def _cost(param: Param, element: str, view: WorldView) -> float:
    """What a candidate costs; what has no number for it comes last."""
    if isinstance(param.cost, str):
        value: object = view.value(element, param.cost)
    else:
        assert param.cost is not None
        value = _worked_out(param.key, param.cost, element, view)
    if isinstance(value, bool) or not isinstance(value, int | float) or math.isnan(value):
        return math.inf
    return float(value)


def _worked_out(key: str, cost: Callable[[WorldView, str], float], element: str, view: WorldView) -> object:
    try:
        return cost(view, element)
    except SkirosError:
        raise
    except Exception as error:
        text = f"the cost of {element} as parameter {key} could not be worked out: {type(error).__name__}: {error}"
        raise DescriptionError(text) from error
