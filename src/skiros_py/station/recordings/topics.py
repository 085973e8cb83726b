"""Topics of a session's recording beyond the common ones: the scene, cameras."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from skiros_py.api.view import ViewElement, WorldView
from skiros_py.execution.runtime import LibraryCall
from skiros_py.geometry import Pose
from skiros_py.ports.frames import MAP
from skiros_py.ports.perception import DetectionRequest, RegistrationRequest
from skiros_py.ports.values import Pending, Snapshot
from skiros_py.recording import foxglove
from skiros_py.recording.foxglove import Json
from skiros_py.recording.pictures import HEIGHT, WIDTH, Camera, from_above, over_the_shoulder, webp
from skiros_py.recording.recorder import Recorder
from skiros_py.recording.topic import Topic
from skiros_py.recording.writer import Write
from skiros_py.station.robots.asked import points_of
from skiros_py.station.session import Session
from skiros_py.station.world.view import view_of
from skiros_py.world.change import Change
from skiros_py.world.index import Index

_MOST_POINTS = 5000
"""Maximum number of points of one observation, before thinning."""
_CUBE = 0.02
"""Voxel size for thinning the points of an observation [m], which is also the size at which they are drawn."""
_MOST_ENTITIES = 1000
"""Number of entities up to which each message contains the whole scene, so that a viewer can jump to any time."""
_COLOURS: Mapping[str, tuple[float, float, float, float]] = {
    "part": (0.78, 0.54, 0.29, 1.0),
    "place": (0.50, 0.62, 0.34, 0.3),
    "floor": (0.72, 0.75, 0.78, 1.0),
}
_GREY = (0.62, 0.66, 0.71, 1.0)


# ---------------------------------------------------------------------- the scene

_SCENE = Topic("/scene", foxglove.SCENE_UPDATE, lambda time, scene: foxglove.scene_update(time, *scene))
VIEW = Topic(
    "/view",
    foxglove.schema("skiros.View", author=foxglove.TEXT, whole=foxglove.FLAG, view=foxglove.OBJECT),
    lambda _time, change: change,
)
"""The visible scene: complete at the beginning, then only visible differences."""


def record_view(recorder: Recorder) -> None:
    """Records the visible scene, for the web page (``/view``) and for Foxglove (``/scene``)."""
    world, board = recorder.runtime.world, recorder.runtime.cycle.board
    frames = recorder.runtime.context.frames
    scene = Scene(lambda snapshot: frames.at(snapshot).platforms())

    def on_change(change: Change) -> None:
        recorder.writer.defer(partial(scene.take, change, world.snapshot(), board.snapshot))

    recorder.on_end(world.subscribe(on_change))
    recorder.writer.defer(partial(scene.begin, world.snapshot(), board.snapshot))


class Scene:
    """Follows the visible scene; in the thread of the writer.

    Args:
        platforms: Returns the poses of the devices that carry bodies.
    """

    def __init__(self, platforms: Callable[[Snapshot], Mapping[str, Pose]]) -> None:
        self._platforms = platforms
        self._seen: dict[str, ViewElement] = {}
        self._shapes: dict[str, Any] = {}

    def begin(self, index: Index, snapshot: Snapshot, write: Write) -> None:
        """Writes the whole scene."""
        view = view_of(index, None, self._platforms(snapshot))
        self._seen, self._shapes = {one.id: one for one in view.elements}, dict(view.shapes)
        self._write(snapshot.time, "", view, write, whole=True)

    def take(self, change: Change, index: Index, snapshot: Snapshot, write: Write) -> None:
        """Writes the visible differences after a change, if any."""
        view = view_of(index, change.marks(), self._platforms(snapshot))
        gone = tuple(name for name in view.gone if name in self._seen)
        if not (view.elements or gone):
            return
        shapes = {key: shape for key, shape in view.shapes.items() if key not in self._shapes}
        self._shapes |= shapes
        self._seen |= {one.id: one for one in view.elements}
        for name in gone:
            del self._seen[name]
        self._write(snapshot.time, change.author, view.model_copy(update={"shapes": shapes, "gone": gone}), write)

    def _write(self, time: float, author: str, view: WorldView, write: Write, *, whole: bool = False) -> None:
        data = view.model_dump(mode="json", by_alias=True)
        write(VIEW, time, {"author": author, "whole": whole, "view": data})
        complete = whole or len(self._seen) <= _MOST_ENTITIES
        shown = self._seen.values() if complete else view.elements
        write(
            _SCENE,
            time,
            ([_entity(one, self._shapes[one.shape]) for one in shown if one.shape], None if complete else view.gone),
        )


def _entity(element: ViewElement, blocks: Any) -> Json:
    """Returns an element as a Foxglove scene entity."""
    frame, pose = element.carrier or MAP, element.pose
    if element.held_by is not None:
        frame, pose = element.held_by, element.in_hand
    at = Pose() if pose is None else Pose(pose.position, pose.orientation)
    colour = (*_COLOURS.get(element.kind, _GREY)[:3], 0.25) if element.hollow else _COLOURS.get(element.kind, _GREY)
    cubes, cylinders = [], []
    for block in blocks if pose is not None else ():
        where = at @ Pose(block.pose.position, block.pose.orientation)
        if block.kind == "box":
            cubes.append(foxglove.cuboid(where, block.size, colour))
        else:
            radius, length = block.size
            cylinders.append(foxglove.cylinder(where, radius, length, colour))
    about = {"class": element.class_, "label": element.label, "place": element.place or ""}
    return foxglove.entity(element.id, frame, about, cubes, cylinders)


# ---------------------------------------------------------------------- cameras


def camera_of(session: Session) -> Camera | None:
    """Returns a function that renders pictures of a session; None if it has nothing to render."""
    if not session.simulates:
        return None

    def picture(snapshot: Snapshot, agent: str) -> Pending[Any]:
        """Renders the workspace of the agent's robot, or of the first one, from behind it; without robots the cell."""
        robots, cell = session.spec.robots, session.simulation
        robot = next((robot for robot in robots if robot.has(agent)), next(iter(robots), None))
        if robot is None:
            view = from_above(*cell.overview())
        else:
            view = over_the_shoulder(robot.pose(snapshot, session.cycle.board.guard))
        return cell.picture(*view, width=WIDTH, height=HEIGHT)

    return picture


def record_observations(recorder: Recorder) -> None:
    """Records each perception request: the picture of the camera, and its points in the map."""

    def on_call(call: LibraryCall) -> None:
        request = call.request
        if isinstance(request, DetectionRequest | RegistrationRequest) and request.camera:
            recorder.put(Topic(f"/camera/{request.camera}", foxglove.COMPRESSED_IMAGE, _image, every=1.0), request)
            recorder.put(Topic(f"/points/{request.camera}", foxglove.POINT_CLOUD, _points, every=1.0), request)

    recorder.on_end(recorder.runtime.asked.subscribe(on_call))


def _image(time: float, request: DetectionRequest | RegistrationRequest) -> Json:
    return foxglove.compressed_image(time, request.camera, webp(np.ascontiguousarray(request.image.colour)), "webp")


def _points(time: float, request: DetectionRequest | RegistrationRequest) -> Json:
    points, colours = points_of(request.image, request.camera_pose, _MOST_POINTS)
    _, kept = np.unique(np.floor(points / _CUBE).astype(np.int32), axis=0, return_index=True)
    return foxglove.point_cloud(time, MAP, points[kept], colours[kept])
