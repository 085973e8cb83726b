"""Loads another scene into a running station, after reading it beside the live world, as one change."""

from __future__ import annotations

from pathlib import Path

from skiros_py.errors import DescriptionError, DeviceError, FileError, UsageError, WrongState
from skiros_py.messages import Message
from skiros_py.skills.cell_reader import read_cell
from skiros_py.skills.restart import respawn
from skiros_py.station.control import ControlThread
from skiros_py.station.scenes.scenes import changes_to
from skiros_py.station.session import Session
from skiros_py.station.worlds import open_data
from skiros_py.world.change import Change, Writer
from skiros_py.world.index import Index
from skiros_py.world.journal.journal import Journal
from skiros_py.world.view import WorldView


def load(
    control: ControlThread,
    data: Path,
    scene: Index,
    *,
    author: str,
    holder: str = "",
    seen: int | None,
) -> None:
    """Replaces the scene of the live world, keeping learned concepts. Returns when the station is up again.

    Robots, skill managers and bodies are then those of the new scene. If they cannot be brought up, the old scene is
    restored.

    Args:
        control: Runs the session.
        data: The data directory.
        scene: The new scene.
        author: The author of the change.
        holder: Owner of the locks that permit it, if not the author.
        seen: Version of the world that the author has seen; None for any.

    Raises:
        WrongState: The station is not idle.
        StaleVersion: The world was changed since.
        WorldError: A lock or a reasoner does not allow it.
        SkirosError: The station cannot be brought up in that scene; it is up in the old one.
    """
    before: list[tuple[Index, Change | None]] = []
    reason = Message("loaded scene {name}", name=scene.source.name or "(upload)")

    def prepare(session: Session) -> None:
        require_rest(session)
        old = session.world.snapshot()
        expects = None if seen is None else {"": seen}
        with session.world.transaction(author, reason, writer=Writer.PERSON, expects=expects, holder=holder) as tx:
            tx.apply(changes_to(scene, old))
        before.append((old, tx.change))

    try:
        control.reopen(prepare, lambda: _take_back(data, *before[0]))
    except (DescriptionError, DeviceError, FileError) as error:
        if not before:
            raise
        raise UsageError(
            "the station cannot be brought up in that scene, and is in the old one: {error}", error=error
        ) from error


def check_scene(session: Session, scene: WorldView) -> None:
    """Checks whether a session such as this one could be opened in another scene.

    Raises:
        UnknownName: The chosen robot is not in it.
        DescriptionError: The description of a robot or body is incomplete, or there is no room for it.
        WorldError: A shape cannot be read.
    """
    spec = read_cell(scene, session.robots_in(scene), simulated=session.simulates)
    if session.simulates:
        from skiros_py.simulation.spawn import start_poses  # physics is an extra

        start_poses(spec, session.options.seed)


def check_reopening(session: Session) -> None:
    """Checks whether a session could be closed and opened again; then updates the beliefs accordingly.

    Raises:
        SkirosError: It could not; the beliefs are unchanged.
    """
    world = session.world
    if session.simulates and isinstance(world.log, Journal):
        respawn(world, world.log, lambda scene: check_scene(session, scene))
    else:
        check_scene(session, world.snapshot())


def require_rest(session: Session) -> None:
    """Checks that the station is idle, and that no job is interrupted in the middle of its work.

    Raises:
        WrongState: It is not idle, or there is such a job.
    """
    if not session.resting:
        raise WrongState(
            "a job, task or module is running or about to start: wait for its end or stop it, and revoke the start of"
            " waiting jobs; nothing was changed"
        )
    held = next((job.id for job in session.jobs.open.values() if job.state.has_begun), None)
    if held is not None:
        raise WrongState(
            "job '{held}' waits in the middle of its work: answer or abort it first; nothing was changed", held=held
        )


def _take_back(data: Path, old: Index, change: Change | None) -> None:
    """Restores the old scene, while no session has the data directory open."""
    with open_data(data, create=False) as directory:
        world = directory.world
        reason = Message("takes the last scene back: the station cannot be brought up in it")
        undoes = None if change is None else change.number
        with world.transaction("server", reason, writer=Writer.PERSON, undoes=undoes) as tx:
            tx.apply(changes_to(old, world.snapshot()))


def shown(error: FileError) -> str:
    """Returns the fault of a scene without the path of its file, which is private."""
    where = f"line {error.line}: " if error.line else ""
    return where + error.reason.replace(str(error.path.parent), "…")
