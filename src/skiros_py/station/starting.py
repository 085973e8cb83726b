"""Starts the adapters of a session: motion, perception, drivers and planners. The session's stack closes them."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, closing
from functools import partial
from typing import TYPE_CHECKING

from skiros_py.catalogue import Catalogue
from skiros_py.errors import UsageError
from skiros_py.geometry import Pose
from skiros_py.planning.process import PlanningProcess, ThreadHost
from skiros_py.planning.requests import PlanningHost
from skiros_py.ports.adapters import InstalledPorts
from skiros_py.ports.cell import CellSpec
from skiros_py.ports.driver import CellDriver, CompositeDriver, Connection
from skiros_py.skills.cell_reader import working_pose
from skiros_py.system import check_system_libraries, require_extra
from skiros_py.world import vocabulary as v
from skiros_py.world.change import Change, PlacementEdit, PropertyEdit
from skiros_py.world.world import World

if TYPE_CHECKING:
    from skiros_py.simulation.fake.cell import FakeCell
    from skiros_py.station.session import Options


def start_ports(stack: ExitStack, spec: CellSpec, *, physics: bool) -> InstalledPorts:
    """Finds the adapters of the cell.

    With physics, adapters with worker processes start immediately: their imports take seconds and run in parallel.
    """
    if physics:
        require_extra("physics", "a simulated run without --fake")
        check_system_libraries()
    ports = stack.enter_context(closing(InstalledPorts(spec.groups, physics=physics)))
    if physics:
        ports.start()
    return ports


def start_cell(stack: ExitStack, spec: CellSpec, catalogue: Catalogue, options: Options, world: World) -> CellDriver:
    """Starts the driver of the cell, and the separate drivers of its robots and devices."""
    if options.fake:
        from skiros_py.simulation.fake.cell import FakeCell

        fake = stack.enter_context(closing(FakeCell(spec, seed=options.seed)))
        stack.callback(_follow_beliefs(fake, spec, world))
        return fake

    def connect(driver: str, part: CellSpec) -> CellDriver:
        return stack.enter_context(closing(Connection(lambda: catalogue.driver(driver, part, seed=options.seed))))

    parts = spec.by_driver()
    own = parts.pop("")
    if options.driver is not None:
        cell: CellDriver = connect(options.driver, own)
    else:
        from skiros_py.simulation.cell import SimulatedCell

        simulated = SimulatedCell(
            own,
            seed=options.seed,
            engine=options.simulation,
            gui=options.gui,
            imperfections=options.imperfections,
        )
        cell = stack.enter_context(closing(simulated))
    _require_devices(cell, own)
    others = [connect(driver, part) for driver, part in parts.items()]
    for other, part in zip(others, parts.values(), strict=True):
        _require_devices(other, part)
    return CompositeDriver([cell, *others]) if others else cell


def _follow_beliefs(cell: FakeCell, spec: CellSpec, world: World) -> Callable[[], None]:
    """Lets each robot without physics stand where it is believed to be, now and later; returns how to end that."""
    carriers = {robot.id: robot.carrier.id for robot in spec.robots if robot.carrier is not None}

    def place(robot: str) -> None:
        if (pose := working_pose(world.snapshot(), robot)) is not None:
            cell.stand(carriers[robot], pose)

    def hear(change: Change) -> None:
        for edit in change.edits:
            match edit:
                case PlacementEdit(element=robot, new=new) if robot in carriers and new is not None:
                    place(robot)
                case PropertyEdit(element=device, property=v.POSE, new=Pose() as pose) if device in carriers.values():
                    cell.stand(device, pose)

    for robot in carriers:
        if (at := world.placement(robot)) and at.place not in world.objects(robot, v.START_LOCATION):
            place(robot)
    return world.subscribe(hear)


def _require_devices(driver: CellDriver, part: CellSpec) -> None:
    """Refuses a driver without some of the devices that it is for.

    Raises:
        UsageError: It lacks some; the message names them.
    """
    missing = [device for device in part.devices if device not in driver.devices]
    if missing:
        has = ", ".join(sorted(driver.devices)) or "none"
        raise UsageError(f"driver '{driver.kind}' has no {', '.join(missing)}, which the scene has; it has {has}")


def start_planning(stack: ExitStack, world: World, catalogue: Catalogue, options: Options) -> PlanningHost:
    """Starts the planning host, which answers requests for plans in a process of its own.

    On the fake cell in lockstep it is a thread: nothing else needs the interpreter while simulated time stands still.
    """
    choose = partial(catalogue.planners_only().choice_of_planners, options.planner, options.planner_command)
    planners = stack.enter_context(closing(choose()))  # an unknown name is refused here
    if options.fake and options.pace is None:
        return stack.enter_context(closing(ThreadHost(world, planners)))
    return stack.enter_context(closing(PlanningProcess(world, choose)))
