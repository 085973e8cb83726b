"""Use cases: devices of any kind, read, opened, closed, jogged and taught with; and signals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any, Literal

from skiros_py.api import robots as api
from skiros_py.api.modules import ModuleRunInfo
from skiros_py.errors import DeviceError, Refused, SkirosError, UnknownName, UsageError, WrongState
from skiros_py.execution.signals import SignalLost, Signals
from skiros_py.messages import Message
from skiros_py.ports.device import to_plain
from skiros_py.ports.driver import CompositeDriver, Connection
from skiros_py.ports.kinematics import JointRange
from skiros_py.ports.signals import Value, dimension_of
from skiros_py.ports.values import Snapshot
from skiros_py.skills.surroundings import owner
from skiros_py.station.modules.runs import ModuleRun, Wish
from skiros_py.station.modules.views import run_info
from skiros_py.station.requests import LIBRARY, Author, Service, addressed, find
from skiros_py.station.session import Session
from skiros_py.world.view import pieces
from skiros_py.world.vocabulary import HELD_BY

Verb = Literal["jog", "teach"]
_UNLIMITED = JointRange(None, None, None)


class DeviceService(Service):
    """Describes and reads devices of any kind, opens and closes them, and moves them by hand."""

    def all(self) -> list[api.DeviceInfo]:
        """Describes all devices of the cell, with the values that each provides."""
        session = self._session
        return [device_info(session, id_) for id_ in session.spec.devices]

    def get(self, id_: str) -> api.DeviceInfo:
        """Describes one device.

        Raises:
            NotFound: There is none with this id.
        """
        with addressed():
            return device_info(self._session, id_)

    def open(self, id_: str) -> api.DeviceInfo:
        """Opens a device: connects its driver, and lets modules use it.

        Raises:
            NotFound: There is none with this id.
            Refused: Its driver cannot be connected.
        """
        connection = self._call(lambda session: _connection_of(session, id_))
        try:
            if connection is not None:
                connection.connect()  # the session continues meanwhile
        except SkirosError as error:
            raise Refused(
                "NotConnected", Message("{device} cannot be opened: {error}", device=id_, error=error)
            ) from error
        self._call(lambda session: session.cycle.board.closed.discard(id_))
        return self.get(id_)

    def close(self, id_: str) -> api.DeviceInfo:
        """Closes a device: no module may use it; with its last device, the driver is disconnected.

        A simulated device stays in the simulation, at a standstill.

        Raises:
            NotFound: There is none with this id.
            WrongState: It is in use, or it moves.
        """

        def close(session: Session) -> Connection | None:
            connection, board = _connection_of(session, id_), session.cycle.board
            with session.managers.claims.request("closing it", {id_}) as claim:
                users = claim.waits_for()
            if users:
                raise WrongState("{users} is in use: stop that first", users=", ".join(users))
            if not board.stand({id_}):
                raise WrongState("{device} moves: wait until it stands still", device=id_)
            board.closed.add(id_)
            return connection if connection is not None and connection.devices.keys() <= board.closed else None

        left = self._call(close)
        driver = None if left is None else self._call(lambda _session: left.disconnect())
        if driver is not None:
            driver.close()
        return self.get(id_)

    def reading(self, id_: str) -> api.DeviceReading:
        """Returns the state of a device, and the values that it provides; does not block.

        Raises:
            NotFound: There is none with this id.
        """
        session = self._session
        device, snapshot = find("device", id_, session.cycle.board.devices), session.cycle.board.snapshot
        state = snapshot.devices.get(id_)
        return api.DeviceReading.view_of(
            snapshot,
            id=id_,
            signals={} if state is None else {signal.name: signal.read(state) for signal in device.signals},
            **device_state(session, snapshot, id_),
        )

    def observation(self, id_: str) -> api.Observation:
        """Returns the last picture of a camera used for perception, as points in the map.

        Raises:
            NotFound: There is no such device.
        """
        return self._station.observations.observation(self._session, id_)

    def motion(self, id_: str) -> api.DeviceMotion:
        """Returns the planned motion of a device.

        Raises:
            NotFound: There is no such device.
        """
        return self._station.motions.motion(self._session, id_)

    def jog(
        self, id_: str, arguments: Mapping[str, Any], *, module: str | None = None, author: Author = LIBRARY
    ) -> ModuleRunInfo:
        """Moves a device by a small step, or home, with a module that its kind names for that.

        Args:
            id_: Id of the device.
            arguments: Parameters of the module, without the device.
            module: The module; None for the first that the kind names.
            author: The author of the request.

        Raises:
            NotFound: There is no such device.
            UsageError: Its kind names no such module, no subsystem can run it, or the arguments are not valid.
            WrongState: It is closed or in use, or everything is halted.
        """
        return self._by_hand(id_, "jog", arguments, module, author)

    def teach(
        self, id_: str, arguments: Mapping[str, Any], *, module: str | None = None, author: Author = LIBRARY
    ) -> ModuleRunInfo:
        """Learns something from the current state of a device, with a module that its kind names for that.

        Arguments and errors are those of :meth:`jog`.
        """
        return self._by_hand(id_, "teach", arguments, module, author)

    def _by_hand(
        self, id_: str, verb: Verb, given: Mapping[str, Any], module: str | None, author: Author
    ) -> ModuleRunInfo:
        def start(session: Session) -> ModuleRun:
            spec = find("device", id_, session.spec.devices)
            names: tuple[str, ...] = getattr(spec, verb)
            if not names:
                raise UsageError(
                    "{device}: devices of kind '{kind}' have no module to {verb}", device=id_, kind=spec.kind, verb=verb
                )
            if module is not None and module not in names:
                raise UnknownName("module", module, names, where=f"to {verb} {id_}")
            name = module or names[0]
            agent = _agent(session, id_, name)
            if agent is None:
                raise UsageError(
                    "no subsystem that could {verb} {device} has the module {name}", verb=verb, device=id_, name=name
                )
            if id_ in session.cycle.board.closed:
                raise WrongState("{device} is closed: open it first", device=id_)
            if busy := _busy(session, agent):
                raise WrongState(
                    "{device} cannot be moved by hand, {busy} is active: wait, or pause or stop that",
                    device=id_,
                    busy=busy,
                )
            arguments = {**given, **_device_parameter(session, agent, name, id_, given)}
            return self._station.module_runs.start(session, Wish(agent, name, arguments, author.name, at_once=True))

        return run_info(self._call(start))


def device_info(session: Session, id_: str) -> api.DeviceInfo:
    """Describes a device; callable in any thread.

    Raises:
        UnknownName: There is none with this id.
    """
    group = session.spec.group_of(id_)
    device = group.device(id_)
    model = session.runtime.context.frames.kinematics(group)
    limits = {} if model is None else model.joints
    robot = group.id if group in session.spec.robots else None
    return api.DeviceInfo.view_of(
        device,
        robot=robot,
        model="" if robot else group.model,
        place=None if robot else group.place,
        description={key: value for key, value in to_plain(device).items() if key != "id"},
        signals=tuple(api.SignalInfo.view_of(s, dimension=dimension_of(s.unit)) for s in device.signals),
        open=id_ not in session.cycle.board.closed,
        commanded=device.target_type is not None,
        joints=tuple(api.JointDescription.view_of(limits.get(j, _UNLIMITED), name=j) for j in device.joint_names),
        frames=device.frame_names,
        jog=_modules(session, id_, device.jog),
        teach=_modules(session, id_, device.teach),
    )


def device_state(session: Session, snapshot: Snapshot, id_: str) -> dict[str, Any]:
    """Returns the state of a device in one cycle as plain data, as :class:`~skiros_py.api.view.DeviceState` has it."""
    board, state = session.cycle.board, snapshot.devices.get(id_)
    device, still, data = board.devices[id_], True, None
    if state is not None:
        with suppress(DeviceError):  # of a kind that fails there is no state; the alarms name it
            still = board.guard.call(device, "still", state)
            data = board.guard.call(device, "encode", state)
    return {
        "still": still,
        "state": data,
        "holds": next(iter(session.world.snapshot().subjects(HELD_BY, id_)), None),
    }


# ---------------------------------------------------------------------- by hand


def _modules(session: Session, device: str, names: Sequence[str]) -> tuple[api.DeviceModule, ...]:
    return tuple(api.DeviceModule(module=name, agent=_agent(session, device, name)) for name in names)


def _agent(session: Session, device: str, module: str) -> str | None:
    """Returns the subsystem that runs a module for a device; None for none.

    That is the device itself, else a subsystem that has it, else another one of its robot. For a device without a
    robot it may be any.
    """
    view = session.world.snapshot()
    robot = owner(view, device)
    near = [agent for agent in sorted(session.managers) if view.has(agent) and robot in (None, owner(view, agent))]
    able = [agent for agent in near if (manager := session.managers.get(agent)) and module in manager.modules]
    return min(able, key=lambda agent: (agent != device, device not in pieces(view, agent)), default=None)


def _device_parameter(
    session: Session, agent: str, module: str, device: str, given: Mapping[str, Any]
) -> dict[str, str]:
    """Returns the parameter that takes the device: the first of its class.

    Raises:
        UsageError: Another device is given for it.
    """
    view = session.world.snapshot()
    type_ = view.element(device).type
    for param in session.managers[agent].info(module).params:
        if param.is_element and view.ontology.is_a(type_, param.element_class):
            if given.get(param.key) not in (None, device):
                raise UsageError(
                    "{key}: it is {device} here, not {given}", key=param.key, device=device, given=given[param.key]
                )
            return {param.key: device}
    return {}


def _busy(session: Session, agent: str) -> str:
    """Returns the activity of a subsystem or its robot; empty if it waits for a person, or is paused between steps."""
    view = session.world.snapshot()
    robot = owner(view, agent)
    agents = {a for a in sorted(session.managers) if a == agent or (robot and view.has(a) and owner(view, a) == robot)}
    running = [f"{name} of {a}" for a in sorted(agents) for name in session.managers[a].running]
    tasks = [
        task.name
        for task in session.tasks.active
        if task.status in ("planning", "running")
        and (task.plan is None or any(agents.intersection(step.arguments.values()) for step in task.plan.steps))
    ]
    return ", ".join([*running, *tasks])


def _connection_of(session: Session, device: str) -> Connection | None:
    """Returns the connection of a device; None if it belongs to the simulation or to the driver of the whole cell."""
    find("device", device, session.cycle.board.devices)
    cell = session.cell
    for driver in cell.drivers if isinstance(cell, CompositeDriver) else (cell,):
        if isinstance(driver, Connection) and device in driver.devices:
            return driver
    return None


# ---------------------------------------------------------------------- signals


class SignalService(Service):
    """Describes, reads and sets signals."""

    def all(self) -> list[api.CellSignal]:
        """Describes all signals, those of the devices first."""
        signals = self._session.runtime.signals
        return [
            api.CellSignal.view_of(
                one := signals.describe(name),
                name=name,
                dimension=dimension_of(one.unit),
                source=signals.source(name),
                input=signals.is_input(name),
            )
            for name in signals.names
        ]

    def read(self, names: Sequence[str]) -> api.SignalReadings:
        """Returns the values of signals in one control cycle.

        Args:
            names: Their names. A stateful signal is computed in every cycle after it is read for the first time.

        Raises:
            NotFound: There is no such signal.
        """

        def readings(session: Session) -> api.SignalReadings:
            values = {name: _reading(session.runtime.signals, name) for name in names}
            return api.SignalReadings.view_of(session.cycle.board.snapshot, signals=values)

        with addressed():
            return self._call(readings)

    def set(self, name: str, value: Value) -> None:
        """Sets an input; the value takes effect in the next cycle.

        Raises:
            NotFound: There is no such signal.
            UsageError: It is not an input, or the value does not have its shape.
        """
        with addressed():
            self._session.runtime.signals.set(name, value)


def _reading(signals: Signals, name: str) -> api.SignalReading:
    try:
        return api.SignalReading(value=signals.read(name).value, reason="")
    except SignalLost as error:
        return api.SignalReading(value=None, reason=error.reason)
