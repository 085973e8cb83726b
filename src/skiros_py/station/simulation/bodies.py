"""Keeps simulated bodies in line with beliefs while the station is idle (D8): scene edits then define the truth.

During a run, edits change beliefs only; a body is then moved by a command of the simulation, unknown to the robots.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

from skiros_py.api.alarms import AlarmKind, Severity
from skiros_py.errors import SkirosError
from skiros_py.ports.cell import BodySpec
from skiros_py.skills.cell_reader import read_body
from skiros_py.station.alarms.alarms import Alarms
from skiros_py.station.control import ControlThread
from skiros_py.station.session import Session
from skiros_py.world import vocabulary as v
from skiros_py.world.change import Change, Edit, ElementEdit, PlacementEdit, PropertyEdit, RelationEdit, Writer
from skiros_py.world.element import is_abstract
from skiros_py.world.index import Index
from skiros_py.world.view import WorldView

_FIXED = (v.ROBOT, v.DEVICE, v.STOCK)
"""Classes whose elements are read only once, when the session is opened."""
_MOST_STALE = 100


class Bodies:
    """Makes the bodies of each session follow edits by people; see :attr:`stale` for edits that cannot be followed.

    Args:
        control: Runs the sessions.
        alarms: Receives the edits that cannot be followed.
    """

    def __init__(self, control: ControlThread, alarms: Alarms) -> None:
        self._control = control
        self._alarms = alarms
        self._stale: dict[str, str] = {}
        self._unsubscribe: Callable[[], None] = lambda: None
        control.on_open(self._open)
        control.on_close(self._close)

    @property
    def stale(self) -> tuple[str, ...]:
        """The edits that take effect only in a new session, as sentences."""
        return tuple(self._stale.values())

    def _open(self, session: Session) -> None:
        self._stale = {}
        for name, why in session.left_out.items():
            self._note(name, f"the station was brought up without {name}: {why}")
        self._unsubscribe = session.world.subscribe(partial(self._hear, session))

    def _close(self, _session: Session) -> None:
        self._unsubscribe()
        self._alarms.clear_all(AlarmKind.STALE)

    def _hear(self, session: Session, change: Change) -> None:
        """Handles a change in the thread that wrote it; must not wait for the control thread, which may notify."""
        if change.writer is Writer.PERSON:
            self._control.soon(partial(self._follow, session, change))

    # ------------------------------------------------------------------ in the control thread

    def _follow(self, session: Session, change: Change, now: Session) -> None:
        if now is not session or not session.resting:
            return
        view = session.world.snapshot()
        for name in _fixed(view, change):
            self._note(name, f"{name} was changed: reset the simulation, and it is brought up like that")
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
            self._put(session, body, moved=body.id in moved)
        session.spec = replace(session.spec, bodies=_bodies(session, view, wanted))

    def _read(self, view: WorldView, name: str) -> BodySpec | None:
        try:
            return read_body(view, name)
        except SkirosError as error:
            self._note(name, f"the body of {name} stays as it is: {error}")
            return None

    def _put(self, session: Session, body: BodySpec, *, moved: bool) -> None:
        scene = session.simulation.scene
        try:
            scene.follow_belief(body.id, body, moved=moved, seed=session.options.seed)
        except SkirosError as error:
            self._note(body.id, f"the body of {body.id} stays as it is: {error}")
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


def _fixed(view: Index, change: Change) -> Iterator[str]:
    """Yields the changed robots, pieces of robots, and stocks, ignoring the believed location of robots."""
    for name in sorted(_touched(view, change.edits, PropertyEdit, RelationEdit, ElementEdit)):
        if any(view.ontology.is_a(view.element(name).type, class_) for class_ in _FIXED):
            yield name
    gone = [edit.old for edit in change.edits if isinstance(edit, ElementEdit) and edit.old is not None]
    for element in gone:
        if not view.has(element.id) and any(view.ontology.is_a(element.type, class_) for class_ in _FIXED):
            yield element.id


def _touched(view: Index, edits: tuple[Edit, ...], *kinds: type[Edit]) -> set[str]:
    """Returns the existing elements with changes that may affect a body."""
    named: set[str] = set()
    for edit in edits:
        if kinds and not isinstance(edit, kinds):
            continue
        if isinstance(edit, PropertyEdit) and edit.property == v.LABEL:
            continue
        if isinstance(edit, RelationEdit):
            named.add(edit.subject)
        elif isinstance(edit, ElementEdit | PlacementEdit | PropertyEdit):
            named.add(edit.element)
    return {n for name in named for n in (name, *_riders(view, name)) if view.has(n) and not is_abstract(n)}


def _moved(view: Index, edits: tuple[Edit, ...]) -> set[str]:
    """Returns the elements that were added or moved, with those that ride on them."""
    named: set[str] = set()
    for edit in edits:
        if isinstance(edit, RelationEdit) and edit.relation == v.POSE_FRAME:
            named.add(edit.subject)
        elif isinstance(edit, ElementEdit | PlacementEdit) or (
            isinstance(edit, PropertyEdit) and edit.property == v.POSE
        ):
            named.add(edit.element)
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
