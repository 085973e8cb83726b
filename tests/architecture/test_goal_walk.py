"""How far a reader has to walk to follow one goal through the task layer; docs/architecture.md shows the walk.

The walk follows a goal from ``TaskManager.begin`` to its report, and visits each method once: when it is first called.
Objects are the classes of ``skiros_py.tasks``. Functions, frozen values and constructors are read where they are used;
a class belongs to its base class, or to the class of the same module that alone uses it. A call of an object that was
visited before is a *return*; a call of an object that is not on a lower level is a *climb*, also where it is repeated.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from types import FrameType

from skiros_py.testing import Bench, tiny_world

LAYER = "skiros_py.tasks."
MOST_RETURNS = 8
LEVELS = {"": 0, "TaskManager": 1, "TaskExecutor": 2, "Replanner": 3, "PlanMonitor": 3, "Dispatcher": 3}
"""From top to bottom; all other objects are below these, and the trace is below them."""
LOWEST = {"Trace": 5}


@dataclass(frozen=True)
class Call:
    """The first call of a method."""

    caller: str
    object: str
    method: str


def test_handling_one_goal_needs_few_returns_and_never_calls_back_up() -> None:
    calls = joined(all_calls())

    assert calls[0] == Call("", "TaskManager", "begin")
    assert len(returns(calls)) <= MOST_RETURNS, returns(calls)
    assert climbs(calls) == []


def test_one_goal_passes_executor_planner_dispatcher_and_monitor_in_this_order() -> None:
    met = dict.fromkeys(call.object for call in joined(all_calls()))

    assert [name for name in met if name in LEVELS] == [
        "TaskManager",
        "TaskExecutor",
        "Replanner",
        "Dispatcher",
        "PlanMonitor",
    ]


# ------------------------------------------------------------------ the walk


def all_calls() -> list[Call]:
    """Returns the calls between methods while a goal is reached, each once, in order."""
    calls: dict[Call, None] = {}

    def record(frame: FrameType, event: str, _argument: object) -> None:
        here = owner(frame) if event == "call" else None
        if here is None or here[1].startswith("__"):
            return
        caller = next(filter(None, map(owner, callers(frame))), None)
        if caller is not None or not calls:
            calls[Call(caller[0] if caller else "", *here)] = None

    with Bench(tiny_world()) as bench:
        goal = bench.goal("In(ball_1, slot_1)")
        sys.setprofile(record)
        try:
            task = bench.tasks.begin(goal)
            for _ in range(5000):
                bench.cycle.step()
                if task.report is not None:
                    break
        finally:
            sys.setprofile(None)
    assert task.report is not None
    assert task.report.reached
    return list(calls)


def owner(frame: FrameType) -> tuple[str, str] | None:
    """Returns class and method that run in a frame; None if that is no method of an object of the task layer."""
    module = frame.f_globals.get("__name__", "")
    name, _, method = frame.f_code.co_qualname.partition(".")
    kind = frame.f_globals.get(name)
    if not (module.startswith(LAYER) and isinstance(kind, type)) or "<" in method:
        return None
    parameters = getattr(kind, "__dataclass_params__", None)
    if parameters is not None and (parameters.frozen or len(vars(kind)["__dataclass_fields__"]) == 0):
        return None
    base = [each for each in kind.__mro__ if each.__module__.startswith(LAYER)][-1]
    return base.__name__, method


def callers(frame: FrameType) -> Iterator[FrameType]:
    while (above := frame.f_back) is not None:
        yield above
        frame = above


def joined(calls: list[Call]) -> list[Call]:
    """Makes each class that only one other class calls a part of that one; returns the calls between objects."""
    names: dict[str, str] = {}

    def whole(name: str) -> str:
        return whole(names[name]) if name in names else name

    for name in dict.fromkeys(call.object for call in calls):
        users = {call.caller for call in calls if call.object == name} - {name}
        if len(users) == 1 and is_part(name, *users):
            names[name] = users.pop()
    between = (Call(whole(c.caller) if c.caller else "", whole(c.object), c.method) for c in calls)
    return [call for call in between if call.caller != call.object]


def is_part(name: str, user: str) -> bool:
    """Returns True if a class is defined in the module of its only user."""
    modules = [m for n, m in sys.modules.items() if n.startswith(LAYER)]
    homes = [
        m.__name__ for m in modules for c in (name, user) if getattr(vars(m).get(c), "__module__", "") == m.__name__
    ]
    return len(homes) == 2 and len(set(homes)) == 1


def returns(calls: list[Call]) -> list[Call]:
    """Returns the calls that lead back to an object, to read another of its methods."""
    visited: set[str] = set()
    read: set[tuple[str, str]] = set()
    found = []
    for call in calls:
        if call.object in visited and (call.object, call.method) not in read:
            found.append(call)
        visited |= {call.object, call.caller}
        read.add((call.object, call.method))
    return found


def climbs(calls: list[Call]) -> list[Call]:
    """Returns the calls that do not lead down."""
    return [call for call in calls if level(call.object) <= level(call.caller)]


def level(name: str) -> int:
    return LEVELS.get(name) or LOWEST.get(name) or 4 * bool(name)
