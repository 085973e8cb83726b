"""One look at a surface: finds the support and the objects on it, and classifies them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

from skiros_py.geometry import Array, Pose, wrap_angle
from skiros_py.open3d import pybind as o3d
from skiros_py.perception.classify import Fit, best_fits, misfits, polish
from skiros_py.perception.elevation import (
    CELL,
    HIGHEST,
    ElevationMap,
    Plane,
    View,
    elevation_map,
    find_support,
    visible_share,
)
from skiros_py.perception.heightmaps import Floats, HeightMap, height_map
from skiros_py.ports.perception import Detection, DetectionRequest, DetectionResult

_LOWEST = 0.008
_EPS = 0.014
_TOUCHING_EPS = 0.0065
_FEWEST_NEIGHBOURS = 6
_HEIGHT_WEIGHT = 0.2
_FEWEST_CELLS = 25
_NARROWEST = 0.008
_BORDER = 0.004


def clusters_of(elevation: ElevationMap, half_extents: tuple[float, float]) -> list[NDArray[np.int64]]:
    """Groups the raised cells within a rectangle around the map's middle.

    Height counts a fifth: a step of 30 mm hides half as much behind it and must not split a part in two.

    Args:
        elevation: The look.
        half_extents: Of the rectangle along x and y [m]; a narrow band inside its border is left out, since a wall
            around it reaches in by the error of its pose.

    Returns:
        Indices of the cells of each cluster, largest cluster first.
    """
    inside = np.abs(elevation.x) <= half_extents[0] - _BORDER
    inside &= np.abs(elevation.y) <= half_extents[1] - _BORDER
    raised = np.flatnonzero(inside & elevation.seen & (elevation.height >= _LOWEST))
    if len(raised) == 0:
        return []
    return groups(elevation, raised, _EPS)


def outline(elevation: ElevationMap, cells: NDArray[np.int64]) -> tuple[float, float, float, float, float]:
    """Returns the box around cells: middle x, middle y [m], yaw of its long side [rad], length and width [m]."""
    points = np.column_stack([elevation.x[cells], elevation.y[cells]]).astype(np.float64)
    angles = np.deg2rad(np.arange(0.0, 90.0, 1.0))
    axes = np.stack([np.cos(angles), np.sin(angles)], axis=0)
    along = points @ axes
    across = points @ np.stack([-axes[1], axes[0]], axis=0)
    spans = np.stack([np.ptp(along, axis=0), np.ptp(across, axis=0)]) + CELL
    best = int((spans[0] * spans[1]).argmin())
    middle_u = (along[:, best].max() + along[:, best].min()) / 2.0
    middle_v = (across[:, best].max() + across[:, best].min()) / 2.0
    yaw, (length, width) = float(angles[best]), spans[:, best]
    cos, sin = np.cos(yaw), np.sin(yaw)
    x, y = cos * middle_u - sin * middle_v, sin * middle_u + cos * middle_v
    if width > length:
        yaw, length, width = yaw + np.pi / 2.0, width, length
    return float(x), float(y), float(yaw), float(length), float(width)


def groups(elevation: ElevationMap, cells: NDArray[np.int64], eps: float) -> list[NDArray[np.int64]]:
    """Groups cells that are nearer than a distance [m]; without slivers, such as walls seen through an inexact border.

    Returns:
        Indices of the cells of each group, largest group first.
    """
    columns = [elevation.x[cells], elevation.y[cells], _HEIGHT_WEIGHT * elevation.height[cells]]
    points: Array = np.column_stack(columns).astype(np.float64)
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    labels = np.asarray(cloud.cluster_dbscan(eps, _FEWEST_NEIGHBOURS), dtype=np.int64)
    found = [cells[labels == label] for label in range(labels.max() + 1)]
    things = [g for g in found if len(g) >= _FEWEST_CELLS and outline(elevation, g)[4] >= _NARROWEST]
    return sorted(things, key=lambda group: (-len(group), int(group[0])))


Cells = NDArray[np.int64]

_SURFACE_WINDOW = 0.080
_AROUND = 0.070
_WORST_FIT = 0.012
_WORST_COST = 0.0035
_LEAST_MARGIN = 0.0015
_LEAST_SEEN = 0.5
_EXPLAINED = 0.5
_RAISED = 0.008
_BESIDE = 0.015
_CLIP = 0.030
_CONTRADICTED = 0.003


@dataclass(frozen=True, slots=True, eq=False)
class _Scene:
    """One look, prepared: points are x, y and height above the support; all in the region's frame [m]."""

    request: DetectionRequest
    plane: Plane
    elevation: ElevationMap
    points: Array


@dataclass(frozen=True, slots=True, eq=False)
class _Thing:
    """A cluster and its best explanation: the type is None where that is not good enough."""

    cells: Cells
    type: str | None
    pose: tuple[float, float, float]
    cost: float
    margin: float


def detect(request: DetectionRequest) -> DetectionResult:
    """Searches one image for parts on one surface.

    Args:
        request: The image, where it was taken, where to search and for what.

    Returns:
        What was seen. The cost of a detection is the mean misfit beyond the doubt about where edges are, about 1 mm
        for the right type; its margin is the lead over the second type, with the misfit where edges do count.
    """
    half = request.region.half_extents
    view = View.of(request.image, request.camera_pose, request.region.pose)
    inside = np.all(np.abs(view.points) <= (*half, _SURFACE_WINDOW), axis=1)
    # A part may cover all of a narrow compartment: no floor is seen there, and its top must not be taken for that.
    plane = Plane(0.0, 0.0, 0.0) if request.region.exact else find_support(view.points[inside], seed=request.seed)
    if plane is None:
        return DetectionResult(None, (), visible_share(view, Plane(0.0, 0.0, 0.0), half))
    elevation = elevation_map(view, plane, (half[0] + _AROUND, half[1] + _AROUND))
    heights = plane.heights(view.points)
    scene = _Scene(request, plane, elevation, np.column_stack([view.points[:, :2], heights])[heights <= HIGHEST])
    found = [_reported(thing, scene) for thing in _things(scene)]
    return DetectionResult(
        surface=(request.region.pose @ Pose.of(0.0, 0.0, plane.offset)).position[2],
        detections=tuple(sorted(found, key=lambda thing: request.region.pose.distance(thing.pose))),
        visible=visible_share(view, plane, half),
    )


def _things(scene: _Scene) -> list[_Thing]:
    explained = np.zeros(len(scene.elevation.x), dtype=np.bool_)
    found: list[_Thing] = []
    for cluster in clusters_of(scene.elevation, scene.request.region.half_extents):
        if explained[cluster].mean() > _EXPLAINED:
            continue  # a piece of a part that is there already
        for thing in _explanations(scene, cluster):
            explained |= _covered(scene, thing)
            found.append(thing)
    half_x, half_y = scene.request.region.half_extents
    return [thing for thing in found if abs(thing.pose[0]) <= half_x and abs(thing.pose[1]) <= half_y]


def _explanations(scene: _Scene, cluster: Cells) -> list[_Thing]:
    """A cluster as one thing, or as several that touch, if some of those are known and it as a whole is not."""
    whole = _explanation(scene, cluster)
    if whole.type is not None:
        return [whole]
    pieces = groups(scene.elevation, cluster, _TOUCHING_EPS)  # where it hangs together by less than two cells
    parts = [_explanation(scene, piece) for piece in pieces] if len(pieces) > 1 else []
    return parts if any(part.type is not None for part in parts) else [whole]


def _explanation(scene: _Scene, cluster: Cells) -> _Thing:
    fits = best_fits(scene.elevation, cluster, scene.request.models)
    if not fits or fits[0].cost > _WORST_FIT:
        return _unknown(scene, cluster, fits[0].cost if fits else math.inf, 0.0)
    # Two types may fit alike where edges count; what they differ in beyond the edges decides then.
    near = [fit for fit in fits if fit.cost <= fits[0].cost + _WORST_COST + _LEAST_MARGIN]
    ranked = sorted(
        ((fit.cost + (exact := _exact(scene, cluster, fit)).cost, exact) for fit in near), key=itemgetter(0)
    )
    best = ranked[0][1]
    rivals = [total for total, _ in ranked[1:]] + [fit.cost for fit in fits[len(near) :]]
    margin = min(rivals, default=math.inf) - ranked[0][0]
    # A bad fit stays unknown: the next look, or a person, may know better; a wrong type would be believed.
    if best.cost > _WORST_COST or best.seen < _LEAST_SEEN or margin < _LEAST_MARGIN:
        return _unknown(scene, cluster, best.cost, margin)
    return _Thing(cluster, best.type, (best.x, best.y, wrap_angle(best.yaw)), best.cost, margin)


def _exact(scene: _Scene, cluster: Cells, fit: Fit) -> Fit:
    """Returns a fit at its exact pose, with what is misfit there beyond the doubt about edges."""
    template = _template(scene, fit.type)
    pose = _sharpened(scene, template, np.array([fit.x, fit.y, fit.yaw], dtype=np.float32))
    x, y, yaw = (float(value) for value in pose)
    return replace(fit, x=x, y=y, yaw=yaw, cost=_mean_misfit(scene.elevation, cluster, template, pose))


def _unknown(scene: _Scene, cluster: Cells, cost: float, margin: float) -> _Thing:
    x, y, yaw, *_ = outline(scene.elevation, cluster)
    return _Thing(cluster, None, (x, y, yaw), cost, margin)


def _template(scene: _Scene, name: str) -> HeightMap:
    return height_map(next(model.solid for model in scene.request.models if model.type == name))


def _sharpened(scene: _Scene, template: HeightMap, pose: Floats) -> Floats:
    distance = np.hypot(scene.points[:, 0] - pose[0], scene.points[:, 1] - pose[1])
    return polish(template, scene.points[distance <= template.radius + _BESIDE], pose, lowest=_RAISED)


def _mean_misfit(elevation: ElevationMap, cluster: Cells, template: HeightMap, pose: Floats) -> float:
    misfit = np.minimum(misfits(template, elevation, pose), _CLIP)
    counted = template.placed(elevation.x, elevation.y, pose[None, :])[0] > _RAISED
    counted[cluster] = True
    counted &= elevation.seen | (misfit > _CONTRADICTED)
    return float(misfit[counted].mean()) if counted.any() else math.inf


def _covered(scene: _Scene, thing: _Thing) -> NDArray[np.bool_]:
    if thing.type is None:
        return np.zeros(len(scene.elevation.x), dtype=np.bool_)
    pose = np.array([thing.pose], dtype=np.float32)
    there = _template(scene, thing.type).placed(scene.elevation.x, scene.elevation.y, pose)[0]
    return np.asarray(there > _RAISED)


def _reported(thing: _Thing, scene: _Scene) -> Detection:
    x, y, yaw = thing.pose
    *_, length, width = outline(scene.elevation, thing.cells)
    size = (length, width, float(scene.elevation.height[thing.cells].max()))
    pose = scene.request.region.pose @ Pose.of(x, y, float(scene.plane.z(x, y)), yaw=yaw)
    return Detection(thing.type, pose, thing.cost, thing.margin, size)
