"""Runs a single skill or primitive in one call."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from skiros_py.catalogue import load_catalogue
from skiros_py.ports.adapters import NO_PORTS, Ports
from skiros_py.ports.cell import CellSpec
from skiros_py.ports.driver import CellDriver
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.conditions import Condition, Verdict
from skiros_py.skills.primitive import Primitive
from skiros_py.skills.skill import Skill
from skiros_py.testing.answering import Answers
from skiros_py.testing.bench import Bench
from skiros_py.testing.cell_faults import CellFault
from skiros_py.testing.faulty_cell import FaultyCell
from skiros_py.testing.module_faults import ModuleFault, spoiled
from skiros_py.testing.planners import GivenPlanner
from skiros_py.testing.trial import SkillTrial
from skiros_py.world.change import Change
from skiros_py.world.world import World

_LIMIT = 600.0
_ANY = "any"
"""A kind of driver for which there is no implementation: those that are for every kind are used."""

Fault = CellFault | ModuleFault
"""Of a device or of a primitive."""
Driver = str | Callable[[CellSpec], CellDriver]
"""Kind of cell: "fake", "pybullet", a name of the group ``skiros.drivers``, or what brings one up."""


def run_skill(
    skill: Skill,
    world: World,
    *,
    primitives: Sequence[type[Primitive[Any]]] = (),
    skills: Sequence[Skill] = (),
    driver: Driver = "fake",
    faults: Sequence[Fault] = (),
    answers: Mapping[str, str] | None = None,
    ports: Ports = NO_PORTS,
    config: Mapping[str, Any] | None = None,
    limit: float = _LIMIT,
    **arguments: Any,
) -> SkillTrial:
    """Runs one implementation of a skill to its end, as fast as possible, and returns all data of the run.

    >>> trial = run_skill(PARK, tiny_world(), primitives=[BackOff], faults=[Fails("back_off")], Place="floor")

    Args:
        skill: The implementation, whichever driver it is for.
        world: Where it runs; it is changed.
        primitives: Primitives that its body uses.
        skills: Further skills that it calls.
        driver: Kind of cell: "fake", "pybullet", the name of a plug-in's driver, or what brings one up.
        faults: Faults of devices and primitives.
        answers: Answers of a person; see :func:`skiros_py.testing.answers`.
        ports: Adapters, for primitives that use them; see :class:`skiros_py.ports.adapters.GivenPorts`.
        config: Values of configuration parameters by "module.key".
        limit: Maximum time of the run [s], after which it is stopped and fails.
        **arguments: Values by parameter key; what is left out is inferred.

    Raises:
        UnknownName: A fault is for a device or primitive that is not there, or no robot can do it.
        DeviceError: The cell broke (:class:`~skiros_py.testing.Dies`).
    """
    offered = [replace(one, driver=None) for one in (skill, *skills)]
    with _bench(world, offered, primitives, driver, faults, ports, config) as bench:
        trial, values = _try(bench, skill.description.name, arguments, answers or {}, limit)
    return replace(trial, verdicts=tuple(_verdict(post, world, values) for post in skill.description.post))


def run_primitive(
    primitive: type[Primitive[Any]],
    world: World,
    *,
    primitives: Sequence[type[Primitive[Any]]] = (),
    driver: Driver = "fake",
    faults: Sequence[Fault] = (),
    answers: Mapping[str, str] | None = None,
    ports: Ports = NO_PORTS,
    config: Mapping[str, Any] | None = None,
    limit: float = _LIMIT,
    **params: Any,
) -> SkillTrial:
    """Runs one primitive to its end, as fast as possible, and returns all data of the run; see :func:`run_skill`.

    >>> trial = run_primitive(BackOff, tiny_world(), base="base_1", robot="robot_1", place="floor", seconds=0.5)

    Args:
        primitive: Its class.
        world: Where it runs; it is changed.
        primitives: Further ones that it calls.
        driver: Kind of cell: "fake", "pybullet", the name of a plug-in's driver, or what brings one up.
        faults: Faults of devices and primitives.
        answers: Answers of a person.
        ports: Adapters, for primitives that use them; see :class:`skiros_py.ports.adapters.GivenPorts`.
        config: Values of configuration parameters by "module.key".
        limit: Maximum time of the run [s], after which it is stopped and fails.
        **params: Its parameters; devices that are left out are those of the robot.
    """
    with _bench(world, (), (primitive, *primitives), driver, faults, ports, config) as bench:
        return _try(bench, primitive.name, params, answers or {}, limit)[0]


def _bench(
    world: World,
    skills: Sequence[Skill],
    primitives: Sequence[type[Primitive[Any]]],
    driver: Driver,
    faults: Sequence[Fault],
    ports: Ports,
    config: Mapping[str, Any] | None,
) -> Bench:
    of_modules = [fault for fault in faults if isinstance(fault, ModuleFault)]
    of_devices = [fault for fault in faults if not isinstance(fault, ModuleFault)]
    return Bench(
        world,
        skills,
        spoiled(primitives, of_modules),
        cell=lambda spec: _cell(driver, spec, of_devices),
        driver=_ANY,
        planner=GivenPlanner(),
        ports=ports,
        config=config,
    )


def _cell(driver: Driver, spec: CellSpec, faults: Sequence[CellFault]) -> CellDriver:
    cell = _made(driver, spec)
    return FaultyCell(cell, *faults) if faults else cell


def _made(driver: Driver, spec: CellSpec) -> CellDriver:
    match driver:
        case "fake":
            return FakeCell(spec)
        case "pybullet":
            from skiros_py.simulation.cell import SimulatedCell  # heavy, and rarely needed

            return SimulatedCell(spec, seed=0)
        case str():
            return load_catalogue().driver(driver, spec, seed=0)
        case _:
            return driver(spec)


def _try(
    bench: Bench, module: str, arguments: Mapping[str, Any], given: Mapping[str, str], limit: float
) -> tuple[SkillTrial, Mapping[str, Any]]:
    """Runs a module to its end; also returns its parameters, with those that were inferred."""
    person = Answers(bench.questions, given)
    changes: list[Change] = []
    unsubscribe = bench.world.subscribe(changes.append)
    start = bench.time
    running = bench.start(module, **arguments)
    # A device that always reports motion never comes to a standstill.
    while not running.done and bench.time - start < limit + 2.0 * bench.cycle.board.braking_time:
        if bench.time - start >= limit:
            running.task.stop(f"it did not end within {limit:g} s")
        bench.cycle.step()
    unsubscribe()
    seconds, asked = bench.time - start, tuple(person.asked)
    trial = SkillTrial(module, running.result, tuple(bench.events), tuple(changes), seconds, questions=asked)
    return trial, running.arguments


def _verdict(condition: Condition, world: World, values: Mapping[str, Any]) -> Verdict:
    open_ = [key for key in condition.arguments if values.get(key) is None]
    if open_:
        return Verdict(False, f"{condition}: {', '.join(open_)} stayed unspecified")
    return condition.evaluate(world, values)
