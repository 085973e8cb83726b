"""What every skill takes for granted of its devices: they are of the robot of the subsystem that does it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from skiros_py.skills.conditions import Computed, Condition, ConditionType, Related, Role, Verdict
from skiros_py.skills.parameters import IT, Kind, Param
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import HAS_A, ROBOT


def of_one_robot(agent: Param, params: Iterable[Param], said: Sequence[Condition]) -> tuple[Condition, ...]:
    """Returns that devices are of the robot of the agent, each one of which the conditions do not say so already.

    Args:
        agent: The subsystem that does it.
        params: All parameters.
        said: What must hold anyway; that one is part of the other says that both are of one robot.
    """
    together = _together(agent.key, said)
    return tuple(
        _condition(agent, param) for param in params if param.kind is Kind.HARDWARE and param.key not in together
    )


def nearest_first(param: Param, agent: str) -> Param:
    """Returns a device's parameter that prefers what the agent itself is built of, where its author prefers nothing."""
    if param.kind is not Kind.HARDWARE or param.preferred or param.cost is not None or param.key == agent:
        return param
    return replace(param, prefer=Computed("sk:hasPiece", agent, IT, _is_piece))


def _together(key: str, said: Iterable[Condition]) -> set[str]:
    """What the conditions say to be of one whole with something, over any number of steps."""
    patterns = (condition.pattern for condition in said)
    links = [{p.subject, p.object} for p in patterns if isinstance(p, Related) and p.relation == HAS_A]
    together = {key}
    while more := {end for link in links if link & together for end in link} - together:
        together |= more
    return together


def _condition(agent: Param, device: Param) -> Condition:
    roles = (Role("agent", agent.element_class), Role("device", device.element_class))
    pattern = Computed("sk:ofOneRobot", "agent", "device", _of_one_robot)
    word = ConditionType("OfOneRobot", roles, pattern, "The device is of the subsystem's own robot.")
    return word(agent.key, device.key)


def _of_one_robot(view: WorldView, agent: str, device: str) -> Verdict:
    robots = (whole for whole in _wholes(view, agent) if view.ontology.is_a(view.element(whole).type, ROBOT))
    whole = next(robots, agent)
    return _is_piece(view, whole, device)


def _is_piece(view: WorldView, whole: str, piece: str) -> Verdict:
    holds = whole in _wholes(view, piece)
    return Verdict(holds, f"{piece} is {'a' if holds else 'no'} piece of {whole}")


def _wholes(view: WorldView, element: str) -> Iterator[str]:
    """Yields an element and everything that it is a piece of, from the bottom."""
    yield element
    for whole in view.subjects(HAS_A, element):
        yield from _wholes(view, whole)
