"""Use cases of a simulated world: true poses of bodies, moving bodies, pace, pictures.

During a run, edits change beliefs only; a body is then moved by a command of the simulation, unknown to the robots.
"""

from __future__ import annotations

import io
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

from skiros_py.api.alarms import AlarmKind, Severity
from skiros_py.api.scenes import Bodies, BodyPose, SimulatedBody, SimulationState
from skiros_py.errors import (
    Busy,
    DescriptionError,
    DeviceError,
    Refused,
    SkirosError,
    UnknownName,
    UsageError,
    WrongState,
)
from skiros_py.geometry import Pose
from skiros_py.messages import Message
from skiros_py.ports.cell import BodySpec
from skiros_py.simulation.cell import SimulatedCell
from skiros_py.skills.cell_reader import read_body
from skiros_py.station.alarms.alarms import Alarms
from skiros_py.station.control import ControlThread
from skiros_py.station.judgement import Whereabouts
from skiros_py.station.requests import addressed, admitted
from skiros_py.station.scenes.loading import check_reopening, require_rest
from skiros_py.station.session import Session
from skiros_py.world import vocabulary as v
from skiros_py.world.change import Change, Edit, ElementEdit, PlacementEdit, PropertyEdit, RelationEdit, Writer
from skiros_py.world.element import is_abstract
from skiros_py.world.index import Index
from skiros_py.world.view import WorldView

_FIXED = (v.ROBOT, v.DEVICE, v.STOCK)
"""Classes whose elements are read only once, when the session is opened."""
_MOST_STALE = 100


Point = tuple[float, float, float]

_ASIDE = 1e-3
"""Offset of an eye that looks straight down [m]; without it, "up" would be undefined in the picture."""


class Simulation:
    """The simulation behind a server's sessions, whose bodies follow edits by people; thread-safe.

    Edits that take effect only in a new session are listed in its state, and raise alarms.

    Args:
        control: Runs the sessions.
        alarms: Receives the edits that cannot be followed.
    """

    def __init__(self, control: ControlThread, alarms: Alarms) -> None:
        self._control = control
        self._alarms = alarms
        self._stale: dict[str, str] = {}
        self._pace: float | None = None
        self._drawing = threading.Lock()

    def state(self) -> SimulationState:
        """Returns the state of the simulation."""
        stuck, stale = self._control.stuck_for(), list(self._stale.values())

        def look(session: Session) -> SimulationState:
            cycle = session.cycle
            return SimulationState.view_of(
                cycle.board.snapshot,
                driver=session.options.driver or ("fake" if session.options.fake else session.options.simulation),
                simulates=session.simulates,
                running=not cycle.halted,
                halted=cycle.halted,
                resting=session.resting,
                pace=cycle.pace,
                period=cycle.board.period,
                stuck=stuck,
                stale=stale,
            )

        return self._control.call(look)

    # ------------------------------------------------------------------ bodies

    def true_bodies(self) -> Bodies:
        """Returns the true poses of all bodies. This is the only use case that reveals the ground truth."""
        from skiros_py.station.judgement import (
            true_whereabouts,  # imports the physics, which an installation with fakes only lacks
        )

        def look(session: Session) -> tuple[float, dict[str, str], Callable[[], Whereabouts]]:
            scene = _cell(session).scene
            specs = [*scene.bodies.values(), *(spec for spec, _ in scene.compartments.values())]
            types = {spec.id: spec.type for spec in specs}
            return session.cycle.board.snapshot.time, types, true_whereabouts(_cell(session))

        time, types, work_out = self._control.call(look)
        poses, places = work_out()  # not in the control thread, because it takes longer than a cycle
        view = self._control.session.world.snapshot()
        items = [
            SimulatedBody.view_of(
                poses[name],
                id=name,
                type=types[name],
                place=places.get(name),
                believed=view.has(name),
            )
            for name in sorted(poses)
        ]
        return Bodies(time=time, items=items)

    def move(self, body: str, pose: BodyPose, *, check: bool = False) -> None:
        """Moves a body, at rest, without informing the robots.

        Args:
            body: Its id.
            pose: Where to.
            check: True to check only whether it has room there.

        Raises:
            NotFound: There is no such body.
            WrongState: It is bolted to a robot, or a region of another body.
            Refused: There it would be inside another body; its data are their ids, with depths [m].
        """

        def do(cell: SimulatedCell) -> None:
            wanted = Pose(pose.position, pose.orientation)
            hits = cell.scene.hits(body, wanted)
            if hits:
                names = ", ".join(f"{name} ({depth * 100:.1f} cm)" for name, depth in sorted(hits.items()))
                raise Refused(
                    "Collision", Message("there {body} would be inside {things}", body=body, things=names), hits=hits
                )
            if not check:
                cell.move_body(body, wanted)

        self._change(body, do)

    def remove(self, body: str) -> None:
        """Removes a body without informing the robots.

        Raises:
            NotFound: There is no such body.
            WrongState: It is bolted to a robot, or a region of another body.
        """
        self._change(body, lambda cell: cell.remove_body(body))

    def _change(self, body: str, edit: Callable[[SimulatedCell], object]) -> None:
        def do(session: Session) -> None:
            cell = _cell(session)
            with addressed("UnknownBody"):
                _require_free(cell, body)
            edit(cell)

        self._control.call(do)

    # ------------------------------------------------------------------ time

    def set_pace(self, pace: float) -> float:
        """Sets the pace, which also holds after the session was reopened; returns it.

        Raises:
            WrongState: The session is in lockstep.
        """

        def do(session: Session) -> None:
            _require_simulated_time(session)
            try:
                session.cycle.set_pace(pace)
            except UsageError as error:
                raise WrongState(str(error)) from None
            self._pace = pace

        self._control.call(do)
        return pace

    def reset(self, *, force: bool = False) -> SimulationState:
        """Reopens the session, with robots where the scene puts them, and bodies as believed.

        Args:
            force: True to stop all activity first; jobs then wait for a person.

        Raises:
            WrongState: The station is not idle, or the believed scene cannot be brought up.
        """

        def prepare(session: Session) -> None:
            _require_simulated_time(session)
            if not force:
                require_rest(session)
            try:
                check_reopening(session)
            except (DescriptionError, UsageError) as error:
                raise WrongState(
                    "nothing was reset, for what is believed cannot be brought up: {error}", error=error
                ) from None

        self._control.reopen(prepare)
        return self.state()

    # ------------------------------------------------------------------ pictures

    def picture(self, eye: Point, target: Point, width: int, height: int) -> bytes:
        """Renders a picture of the whole scene as it is now.

        Args:
            eye: Position of the observer in the map [m].
            target: Point at which the observer looks [m].
            width: Width of the picture [px].
            height: Height of the picture [px].

        Returns:
            The picture as PNG.

        Raises:
            UsageError: Both points are the same.
            Busy: Another picture is being rendered.
        """
        from PIL import Image  # imported only for pictures

        seen_from = _not_straight_down(eye, target)
        full = Message("another picture is being made: one at a time, for robots' cameras need the same process")
        file = io.BytesIO()
        with admitted(self._drawing, full):
            try:
                drawing = self._control.call(
                    lambda session: _cell(session).picture(seen_from, target, width=width, height=height)
                )
                Image.fromarray(drawing.result()).save(file, "PNG")
            except DeviceError as error:
                raise Busy(
                    Message("no picture: {error}; perhaps the simulation is being brought up again", error=error)
                ) from None
        return file.getvalue()

    # ------------------------------------------------------------------ edits, in the control thread

    def open(self, session: Session) -> None:
        """Gives a session the pace that was set, and makes its bodies follow edits."""
        if self._pace is not None and session.cycle.pace is not None:
            session.cycle.set_pace(self._pace)
        self._stale = {}
        for name, why in session.left_out.items():
            self._note(name, Message("the station was brought up without {name}: {why}", name=name, why=why))
        session.on_close(
            partial(self._alarms.clear_all, AlarmKind.STALE), session.world.subscribe(partial(self._hear, session))
        )

    def _hear(self, session: Session, change: Change) -> None:
        """Handles a change in the thread that wrote it; must not wait for the control thread, which may notify."""
        if change.writer is Writer.PERSON:
            self._control.soon(partial(self._follow, session, change))

    def _follow(self, session: Session, change: Change, now: Session) -> None:
        if now is not session or not session.resting:
            return
        view = session.world.snapshot()
        robots = session.spec.robots if session.options.fake else ()  # they stand where they are believed to be
        carriers = {robot.carrier.id for robot in robots if robot.carrier is not None}
        for name in _fixed(view, tuple(edit for edit in change.edits if not _moves(edit, carriers))):
            self._note(
                name, Message("{name} was changed: reset the simulation, and it is brought up like that", name=name)
            )
        if session.simulates:
            self._move_bodies(session, view, change)

    def _move_bodies(self, session: Session, view: Index, change: Change) -> None:
        wanted = [body for name in sorted(_touched(view, change.edits)) if (body := self._read(view, name)) is not None]
        for name in sorted({edit.element for edit in change.edits if isinstance(edit, ElementEdit)}):
            if not view.has(name):
                self._settle(name)
                session.simulation.scene.follow_belief(name, None, moved=True, seed=0)
        wanted.sort(key=lambda body: (body.mass > 0.0, body.compartment, body.id))  # carriers first
        moved = _moved(view, change.edits)
        for body in wanted:
            self._put(session, body, moved=body.id in moved, passing=moved)
        session.spec = replace(session.spec, bodies=_bodies(session, view, wanted))

    def _read(self, view: WorldView, name: str) -> BodySpec | None:
        try:
            return read_body(view, name)
        except SkirosError as error:
            self._note(name, Message("the body of {name} stays as it is: {error}", name=name, error=error))
            return None

    def _put(self, session: Session, body: BodySpec, *, moved: bool, passing: set[str]) -> None:
        scene = session.simulation.scene
        try:
            scene.follow_belief(body.id, body, moved=moved, seed=session.options.seed, passing=passing)
        except SkirosError as error:
            self._note(body.id, Message("the body of {name} stays as it is: {error}", name=body.id, error=error))
        else:
            self._settle(body.id)

    def _note(self, name: str, sentence: str) -> None:
        if name in self._stale or len(self._stale) < _MOST_STALE:
            self._stale[name] = sentence
            self._alarms.raise_(AlarmKind.STALE, sentence, name, severity=Severity.LOW)

    def _settle(self, name: str) -> None:
        """Records that a body agrees with its belief."""
        self._stale.pop(name, None)
        self._alarms.clear(AlarmKind.STALE, name)


def _moves(edit: Edit, devices: set[str]) -> bool:
    return isinstance(edit, PropertyEdit) and edit.property == v.POSE and edit.element in devices


def _fixed(view: Index, edits: tuple[Edit, ...]) -> Iterator[str]:
    """Yields the changed robots, pieces of robots, and stocks, ignoring the believed location of robots."""
    named = sorted(_touched(view, edits, PropertyEdit, RelationEdit, ElementEdit))
    old = [edit.old for edit in edits if isinstance(edit, ElementEdit) and edit.old is not None]
    for element in (*map(view.element, named), *(element for element in old if not view.has(element.id))):
        if any(view.ontology.is_a(element.type, class_) for class_ in _FIXED):
            yield element.id


def _touched(view: Index, edits: tuple[Edit, ...], *kinds: type[Edit]) -> set[str]:
    """Returns the existing elements with changes that may affect a body."""
    relevant = (edit for edit in edits if not kinds or isinstance(edit, kinds))
    told = (edit for edit in relevant if not (isinstance(edit, PropertyEdit) and edit.property == v.LABEL))
    named = {name for edit in told for name in edit.marks()[:1]}  # of a relation its subject
    return {n for name in named for n in (name, *_riders(view, name)) if view.has(n) and not is_abstract(n)}


def _moved(view: Index, edits: tuple[Edit, ...]) -> set[str]:
    """Returns the elements that were added or moved, with those that ride on them."""
    named: set[str] = set()
    for edit in edits:
        match edit:
            case RelationEdit(subject=name, relation=v.POSE_FRAME):
                named.add(name)
            case ElementEdit(element=name) | PlacementEdit(element=name) | PropertyEdit(element=name, property=v.POSE):
                named.add(name)
    return {n for name in named for n in (name, *_riders(view, name))}


def _riders(view: Index, name: str) -> Iterator[str]:
    """Yields the elements with poses in the frame of an element, recursively; the frames are a tree."""
    waiting = [name] if view.has(name) else []
    for frame in waiting:
        riders = view.subjects(v.POSE_FRAME, frame)
        waiting += riders
        yield from riders


def _bodies(session: Session, view: WorldView, changed: list[BodySpec]) -> tuple[BodySpec, ...]:
    """Returns the cell's bodies as described now; bodies in stock are not elements, and are kept."""
    new = {body.id: body for body in changed}
    stays = [new.pop(b.id, b) for b in session.spec.bodies if view.has(b.id) or "#" in b.id]
    return tuple(sorted((*stays, *new.values()), key=lambda b: (b.mass > 0.0, b.compartment, b.id)))


def _cell(session: Session) -> SimulatedCell:
    if not session.simulates:
        raise Refused(
            "NoSimulation", Message("no physics is simulated behind these robots: start without --fake or --driver")
        )
    return session.simulation


def _require_simulated_time(session: Session) -> None:
    if session.options.driver is not None:
        raise Refused(
            "NoSimulation", Message("these robots are real or simulated by another program, which controls their time")
        )


def _require_free(cell: SimulatedCell, body: str) -> None:
    if body in cell.scene.compartments:
        raise WrongState(
            "'{name}' is a region of {whole}, and moves with it only",
            name=body,
            whole=cell.scene.compartments[body][0].place,
        )
    there = cell.scene.bodies.get(body)
    if there is None:
        raise UnknownName("body", body, cell.scene.bodies)
    if there.carrier is not None:
        raise WrongState("'{name}' is bolted to {whole}, and moves with it only", name=body, whole=there.carrier)


def _not_straight_down(eye: Point, target: Point) -> Point:
    if max(abs(a - b) for a, b in zip(eye, target, strict=True)) < _ASIDE:
        raise UsageError("eye and target are one point: say where to look from, and where to")
    if max(abs(eye[0] - target[0]), abs(eye[1] - target[1])) < _ASIDE:
        return eye[0] + _ASIDE, eye[1], eye[2]
    return eye
