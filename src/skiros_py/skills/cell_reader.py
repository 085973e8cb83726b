"""Reads the cell from the world model: bodies and robots as the plain data that drivers and adapters take.

Same skills on another robot: other individuals only (paper §5.1).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from skiros_py.errors import DescriptionError, SkirosError
from skiros_py.geometry import Pose
from skiros_py.interruptions import limited
from skiros_py.ports.calibration import MarkerBoard
from skiros_py.ports.cell import BodySpec, CellSpec, RobotSpec
from skiros_py.ports.device import DeviceSpec, MobileSpec, read_footprint
from skiros_py.ports.device_faults import require_description
from skiros_py.ports.device_kinds import DeviceKinds, load_device_kinds
from skiros_py.ports.paths import floor_area, placed
from skiros_py.skills.surroundings import is_held, owner, solid_of
from skiros_py.world import vocabulary as v
from skiros_py.world.poses import driving_pose, frames, pose_on
from skiros_py.world.stock import Stocked, stocks
from skiros_py.world.view import WorldView, pieces

_FAR, _HEAVY = 1000.0, 1000.0
"""Greatest distance from the map's origin [m] and greatest mass [kg] that make sense for a cell."""
_LONGEST = 30.0
"""Wall time in which a kind of device has to read an individual [s]."""
_TOUCHING, _LOW = 0.02, 0.2
"""How far a base may start inside something, and up to which height above its start that counts [m]."""
_MOST_STOCKED = 1000
"""So many things of one stock a simulation is asked to have bodies for at most; no place has room for that many."""


def read_cell(
    view: WorldView,
    robots: Sequence[str],
    *,
    simulated: bool = True,
    left_out: dict[str, str] | None = None,
) -> CellSpec:
    """Reads every body with a shape, the given robots, and the devices that belong to no robot.

    Args:
        view: The world.
        robots: Ids of the robots.
        simulated: False where the bodies are not simulated: then a robot may hold something from the start,
            and what is in stock has no bodies, however much it is.
        left_out: Gets each body that cannot be read, with the reason, and what lies in one: the cell does without them.
            None to have that raised.

    Raises:
        DescriptionError: A robot or body lacks something; the message names the element and the property.
    """
    for root in (v.FLOOR, v.UNKNOWN_LOCATION):
        if not view.instances(root):
            raise DescriptionError(f"the scene has no {root}: things that fall or get lost need a place")
    bodies: list[BodySpec] = []
    for element in (*view.instances(v.SPATIAL_THING), *view.instances(v.STOCK)):
        try:
            bodies += _bodies(view, element, simulated=simulated)
        except SkirosError as error:
            if left_out is None:
                raise
            left_out[element] = str(error)
    if left_out:
        bodies = _without(bodies, left_out)
    bodies.sort(key=lambda body: (body.mass > 0.0, body.compartment, body.id))
    kinds = load_device_kinds()[0]
    cell = CellSpec(tuple(bodies), tuple(_robot(view, robot, kinds) for robot in robots), _single(view, kinds))
    if simulated and left_out is None:  # later on, people may have put things there
        for robot in cell.robots:
            _require_room(robot, cell.bodies)
    return cell


def read_body(view: WorldView, element: str) -> BodySpec | None:
    """Reads one body.

    Args:
        view: The world.
        element: Id of an element.

    Returns:
        The body, or None for what has no shape, is missing, or is a robot or a piece of one.

    Raises:
        UnknownName: There is no such element.
        DescriptionError: The body lacks something.
        WorldError: Its shape cannot be read.
    """
    ontology, type_ = view.ontology, view.element(element).type
    if not ontology.is_a(type_, v.SPATIAL_THING) or any(ontology.is_a(type_, class_) for class_ in (v.ROBOT, v.DEVICE)):
        return None
    solid = solid_of(view, element)
    is_lost = view.value(element, v.MISSING) is True and view.value(element, v.POSE) is None
    if solid is None or (is_lost and not _place(view, element)):  # there is none until somebody says where it is
        return None
    carrier, pose = _pose(view, element) or (None, None)
    place = _place(view, element)
    _check_start(view, element, pose, place)
    compartment, mass = _is_compartment(view, element), _mass(view, element)
    board = read_board(view, element)
    body = BodySpec(element, type_, solid, mass, pose, place, carrier, compartment=compartment, board=board)
    if None in (view.value(element, v.SUPPORT_HALF_EXTENTS), view.value(element, v.SUPPORT_OFFSET)):
        return body
    individual = _Individual(view, element)
    (half_x, half_y), (x, y, z) = individual.vector(v.SUPPORT_HALF_EXTENTS, 2), individual.vector(v.SUPPORT_OFFSET, 3)
    return replace(body, support=(half_x, half_y), support_centre=(x, y), support_height=z)


def read_board(view: WorldView, element: str) -> MarkerBoard | None:
    """Returns the board that is printed on an element; None for what is no marker board.

    Raises:
        DescriptionError: The board lacks something.
    """
    if not view.ontology.is_a(view.element(element).type, v.MARKER_BOARD):
        return None
    individual = _Individual(view, element)
    columns, rows = individual.vector(v.SQUARES, 2)
    return MarkerBoard(int(columns), int(rows), individual.number(v.SQUARE_SIDE), individual.number(v.MARKER_SIDE))


def working_pose(view: WorldView, robot: str) -> Pose | None:
    """Returns the pose in the map from which a robot works where it is believed to be; None where that has none."""
    placement = view.placement(robot)
    return None if placement is None else driving_pose(view, placement.place)


def has_base(view: WorldView, robot: str) -> bool:
    """Returns True when one of a robot's devices moves it through the map."""
    kinds = load_device_kinds()[0]
    found = (_kind(view, piece, kinds) for piece in pieces(view, robot)[1:])
    return any(kind is not None and issubclass(kind, MobileSpec) for kind in found)


def _bodies(view: WorldView, element: str, *, simulated: bool) -> list[BodySpec]:
    """Returns the bodies of one element: several where it is a stock, none where it has no shape or is not there."""
    if view.ontology.is_a(view.element(element).type, v.STOCK):
        return _stocked(view, element, simulated=simulated)
    body = read_body(view, element) if simulated or not is_held(view, element) else None
    return [] if body is None else [body]


def _without(bodies: list[BodySpec], left_out: dict[str, str]) -> list[BodySpec]:
    """Leaves out what lies in something that was left out, and so on."""
    while homeless := [body for body in bodies if body.place in left_out]:
        for body in homeless:
            left_out[body.id.partition("#")[0]] = f"it lies in {body.place}, which is not there"
        bodies = [body for body in bodies if body not in homeless]
    return bodies


def _stocked(view: WorldView, element: str, *, simulated: bool) -> list[BodySpec]:
    """Returns the bodies of things that have no individuals; where in their container they lie is not known."""
    class_, count = view.value(element, v.STOCK_OF), view.value(element, v.STOCK_COUNT)
    if not isinstance(class_, str) or not view.ontology.is_a(class_, v.MANIPULATABLE):
        raise DescriptionError(f"{element}: sk:stockOf is {class_}, not a class of {v.MANIPULATABLE}")
    if not isinstance(count, int):
        raise DescriptionError(f"{element} has no sk:stockCount: say how many {class_} there are")
    if not view.subjects(v.HAS_A, element):
        raise DescriptionError(f"{element} is a stock of no place: let a container have it by sk:hasA")
    own = next((stock for stock in stocks(view) if stock.id == element), None)
    if own is None or not simulated:
        return []  # used up, or not needed
    shown = Stocked(view, {own: [own.token(1)]})
    solid = solid_of(shown, own.token(1))
    if solid is None:
        return []
    mass, place = _mass(shown, own.token(1)), own.placement.place
    if count > _MOST_STOCKED:
        raise DescriptionError(
            f"{element}: no room on '{place}' for {count} of {class_}: physics takes {_MOST_STOCKED} of a stock at most"
        )
    return [BodySpec(own.token(n), class_, solid, mass, place=place) for n in range(1, count + 1)]


def _check_start(view: WorldView, element: str, pose: Pose | None, place: str | None) -> None:
    placement = view.placement(element)
    if placement is not None and placement.relation == v.HELD_BY:
        raise DescriptionError(f"{element} starts in {placement.place}: no part can, put it in a storage place")
    if pose is None and place is None:
        raise DescriptionError(_lost_in(view, element) or f"{element} has neither a pose nor a place: say where it is")
    if pose is not None and _is_far(pose):
        far = next((name for name in frames(view, element) if _is_far(view.value(name, v.POSE))), element)
        by_way = "" if far == element else f", and so is {element}, whose pose is in its frame"
        raise DescriptionError(f"{far}: its pose is more than {_FAR:.0f} m away{by_way}; lengths are in metres")


def _is_far(pose: object) -> bool:
    return isinstance(pose, Pose) and max(map(abs, pose.position)) > _FAR


def _lost_in(view: WorldView, element: str) -> str:
    """Returns which frame leaves an element's pose in the map unknown; empty if the element itself has no pose."""
    unknown = next((frame for frame in frames(view, element) if view.value(frame, v.POSE) is None), element)
    if unknown == element:
        return ""
    return f"{unknown} has no {v.POSE}, and the pose of {element} is given in its frame: say where {unknown} is"


def _mass(view: WorldView, element: str) -> float:
    mass = _Individual(view, element).number(v.MASS, 0.0)
    movable = view.ontology.is_a(view.element(element).type, v.MANIPULATABLE)
    if not 0.0 <= mass <= _HEAVY or (movable and mass == 0.0):
        low = "above 0" if movable else "0 (never moves)"
        raise DescriptionError(f"{element}: sk:mass {mass:g} kg is not between {low} and {_HEAVY:g} kg")
    return mass


def _place(view: WorldView, element: str) -> str | None:
    """Returns what a thing lies in, or may lie in, and for a compartment the kit that has it."""
    if _is_compartment(view, element):
        return next(iter(view.subjects(v.HAS_A, element)), None)
    placement = view.placement(element)
    return placement.place if placement and placement.relation in (v.IN, v.MAY_BE_IN) else None


def _is_compartment(view: WorldView, element: str) -> bool:
    return view.value(element, v.HOLLOW) is True


def _pose(view: WorldView, element: str) -> tuple[str | None, Pose] | None:
    """Returns the id of the device that carries an element, and the pose in its frame; None and the pose in the map."""

    def known(frame: str) -> Pose | None:
        kind = _kind(view, frame, load_device_kinds()[0]) if _is_device(view, frame) else None
        return Pose() if kind is not None and kind.carries else None

    return pose_on(view, element, known)


def _robot(view: WorldView, robot: str, kinds: DeviceKinds) -> RobotSpec:
    """Reads a robot; one that nothing moves stands where its own pose says."""
    devices = _devices(view, pieces(view, robot)[1:], kinds)
    spec = RobotSpec(robot, _Individual(view, robot).text(v.MODEL), devices, **_driven(view, robot, devices))
    carriers = [device for device in spec.devices if isinstance(device, MobileSpec)]
    if len(carriers) > 1:
        raise DescriptionError(f"{robot} is moved by {' and '.join(c.id for c in carriers)}: one can carry it")
    movers: dict[tuple[str, str], str] = {}
    for device in spec.devices:
        for joint in device.joint_names:
            other = movers.setdefault((device.kind, joint), device.id)
            if other != device.id:
                raise DescriptionError(
                    f"{other} and {device.id} both have joint '{joint}' of {robot}: give each its own"
                )
    return spec if carriers else _standing(view, spec)


def _standing(view: WorldView, spec: RobotSpec) -> RobotSpec:
    individual = _Individual(view, spec.id)
    found = _pose(view, spec.id)
    if found is None:
        unposed = f"{spec.id} has no sk:pose, and no device that moves it: say where it stands"
        raise DescriptionError(_lost_in(view, spec.id) or unposed)
    outline = read_footprint(individual) if view.value(spec.id, v.FOOTPRINT) is not None else ()
    return replace(spec, place=found[1], footprint=outline)


def _require_room(robot: RobotSpec, bodies: Sequence[BodySpec]) -> None:
    """Refuses a base that starts inside something that never moves: physics would throw it out, or let it stick."""
    if robot.carrier is None:
        return
    area, low = placed(robot.outline, robot.start).buffer(-_TOUCHING), robot.start.position[2] + _TOUCHING
    for body in bodies:
        if body.mass > 0.0 or body.pose is None or body.carrier is not None or body.compartment:
            continue
        if area.intersects(floor_area(body.solid, body.pose, low, low + _LOW)):
            raise DescriptionError(f"{robot.carrier.id} starts inside {body.id}: give it an sk:pose on free floor")


def _single(view: WorldView, kinds: DeviceKinds) -> tuple[RobotSpec, ...]:
    """Reads the devices that belong to no robot: a camera over a table, a turntable."""
    groups = []
    for device in view.instances(v.DEVICE):
        if owner(view, device) is None and not any(_is_device(view, one) for one in view.subjects(v.HAS_A, device)):
            model = view.value(device, v.MODEL)
            devices = _devices(view, pieces(view, device), kinds)
            driven = _driven(view, device, devices)
            group = RobotSpec(device, model if isinstance(model, str) else "", devices, **driven)
            if devices:
                groups.append(group if group.carrier is not None else _standing(view, group))
    return tuple(groups)


def _driven(view: WorldView, group: str, devices: Sequence[DeviceSpec[Any, Any]]) -> dict[str, Any]:
    """Reads which driver a robot or device has, at which address, which of its devices have their own, and adapters."""
    individual = _Individual(view, group)
    driver, address, named = (individual.text(property_, "") for property_ in (v.DRIVER, v.ADDRESS, v.ADAPTER))
    own, adapters = [], [(group, tuple(named.split()))] if named else []
    for device in devices:
        reached = _Individual(view, device.id)
        found = reached.text(v.DRIVER, driver), reached.text(v.ADDRESS, address)
        if found != (driver, address):
            own.append((device.id, *found))
        if device.id != group and (names := reached.text(v.ADAPTER, "")):
            adapters.append((device.id, tuple(names.split())))
    return {"driver": driver, "address": address, "drivers": tuple(own), "adapters": tuple(adapters)}


def _devices(view: WorldView, pieces: Sequence[str], kinds: DeviceKinds) -> tuple[DeviceSpec[Any, Any], ...]:
    """Reads those pieces that are devices of a kind that somebody brings; others are words without hardware."""
    of_pieces = ((piece, _kind(view, piece, kinds)) for piece in pieces)
    return tuple(_device(_Individual(view, piece), kind, kinds) for piece, kind in of_pieces if kind is not None)


def _device(individual: _Individual, kind: type[DeviceSpec[Any, Any]], kinds: DeviceKinds) -> DeviceSpec[Any, Any]:
    """Reads a device.

    Raises:
        DescriptionError: Its individual lacks something, or its kind fails; the message names both.
    """

    def name() -> str:
        return kinds.describe(individual.id, kind)

    try:
        device = limited(name, _LONGEST, lambda: kind.read(individual))
        if not isinstance(device, kind):
            raise DescriptionError(f"{name()} cannot be read: read returned {device!r:.60}, not a {kind.__name__}")
        require_description(device)
    except SkirosError:
        raise
    except Exception as error:
        raise DescriptionError(f"{name()} cannot be read: {type(error).__name__}: {error}") from error
    return device


def _kind(view: WorldView, element: str, kinds: DeviceKinds) -> type[DeviceSpec[Any, Any]] | None:
    ontology = view.ontology

    def is_a(class_: str, other: str) -> bool:
        return other in ontology.classes and ontology.is_a(class_, other)  # a kind's ontology may not be loaded

    return kinds.of_class(view.element(element).type, is_a)


def _is_device(view: WorldView, element: str) -> bool:
    return view.ontology.is_a(view.element(element).type, v.DEVICE)


class _Individual:
    """An individual of a world, as a kind of device reads it; a :class:`skiros_py.ports.device.Individual`."""

    def __init__(self, view: WorldView, element: str) -> None:
        self._view = view
        self.id = element

    def number(self, property_: str, default: float | None = None) -> float:
        """Returns a number."""
        value = self._value(property_, default)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise DescriptionError(f"{self.id} has no number for {property_}")
        return float(value)

    def text(self, property_: str, default: str | None = None) -> str:
        """Returns a text."""
        value = self._value(property_, default)
        if not isinstance(value, str):
            raise DescriptionError(f"{self.id} has no text for {property_}")
        return value

    def _value(self, property_: str, default: object) -> object:
        value = self._view.value(self.id, property_)
        return default if value is None else value

    def vector(
        self, property_: str, length: int | None = None, default: tuple[float, ...] | None = None
    ) -> tuple[float, ...]:
        """Returns numbers."""
        value = self._value(property_, default)
        if not isinstance(value, tuple):
            raise DescriptionError(f"{self.id} has no numbers for {property_}")
        if length is not None and len(value) != length:
            raise DescriptionError(f"{self.id}: {property_} takes {length} numbers, not {len(value)}")
        return value

    def pose(self, property_: str = v.POSE) -> Pose | None:
        """Returns a pose."""
        pose = self._view.value(self.id, property_)
        return pose if isinstance(pose, Pose) else None

    def owner(self, class_: str) -> str | None:
        """Returns the nearest owner of a class."""
        owners = self._view.subjects(v.HAS_A, self.id)
        return next((found for one in owners if (found := owner(self._view, one, class_)) is not None), None)
