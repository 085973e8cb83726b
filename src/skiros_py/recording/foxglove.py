"""Messages and JSON schemas of Foxglove (https://docs.foxglove.dev/docs/sdk/schemas), as far as they are recorded."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from skiros_py.geometry import Array, Pose

Json = Mapping[str, Any]
_DIGITS = 5
_GRID = 256.0
"""Points lie on a grid of 4 mm, which compresses three times as well [1/m]."""
_FLOAT32, _UINT8 = 7, 1
_INFO = 2
_MATCHING, _ALL = 0, 1


@dataclass(frozen=True, slots=True)
class Schema:
    """A JSON schema under the name by which other programs know it.

    Foxglove reads a part of JSON Schema only: an object whose properties are of type boolean, string, number, integer,
    object, or array of one of these; no references and no alternatives of types. A property that does not fit is left
    out, which allows anything.
    """

    name: str
    data: Json


# ---------------------------------------------------------------------- schemas


NUMBER, WHOLE, TEXT, FLAG, OBJECT = ({"type": name} for name in ("number", "integer", "string", "boolean", "object"))


def schema(name: str, /, **properties: Json) -> Schema:
    """Returns the schema of an object that has all of these properties."""
    return Schema(name, _object(name, **properties))


def list_of(items: Json) -> Json:
    """Returns the schema of a list."""
    return {"type": "array", "items": items}


def _object(title: str, /, **properties: Json) -> dict[str, Any]:
    return {"title": title, "type": "object", "properties": properties, "required": list(properties)}


def _one_of(*names: str) -> Json:
    return {"oneOf": [{"title": name, "const": number} for number, name in enumerate(names)]}


_COUNT = {**WHOLE, "minimum": 0}
_BYTES = {**TEXT, "contentEncoding": "base64"}
_TIME = _object("time", sec=_COUNT, nsec={**_COUNT, "maximum": 999_999_999})
_DURATION = _object("duration", sec=WHOLE, nsec={**_COUNT, "maximum": 999_999_999})
_VECTOR = _object("foxglove.Vector3", x=NUMBER, y=NUMBER, z=NUMBER)
_QUATERNION = _object("foxglove.Quaternion", x=NUMBER, y=NUMBER, z=NUMBER, w=NUMBER)
_POSE = _object("foxglove.Pose", position=_VECTOR, orientation=_QUATERNION)
_COLOR = _object("foxglove.Color", r=NUMBER, g=NUMBER, b=NUMBER, a=NUMBER)
_TRANSFORM = _object(
    "foxglove.FrameTransform",
    timestamp=_TIME,
    parent_frame_id=TEXT,
    child_frame_id=TEXT,
    translation=_VECTOR,
    rotation=_QUATERNION,
)
_CUBE = _object("foxglove.CubePrimitive", pose=_POSE, size=_VECTOR, color=_COLOR)
_CYLINDER = _object(
    "foxglove.CylinderPrimitive",
    pose=_POSE,
    size=_VECTOR,
    bottom_scale=NUMBER,
    top_scale=NUMBER,
    color=_COLOR,
)
_UNUSED = ("arrows", "spheres", "lines", "triangles", "texts", "models")
"""Parts that an entity must have, and that are always empty here."""
_ENTITY = _object(
    "foxglove.SceneEntity",
    timestamp=_TIME,
    frame_id=TEXT,
    id=TEXT,
    lifetime=_DURATION,
    frame_locked=FLAG,
    metadata=list_of(_object("foxglove.KeyValuePair", key=TEXT, value=TEXT)),
    cubes=list_of(_CUBE),
    cylinders=list_of(_CYLINDER),
    **dict.fromkeys(_UNUSED, list_of(OBJECT)),
)
_DELETION = _object("foxglove.SceneEntityDeletion", timestamp=_TIME, type=_one_of("MATCHING_ID", "ALL"), id=TEXT)
_NUMERIC = _one_of("UNKNOWN", "UINT8", "INT8", "UINT16", "INT16", "UINT32", "INT32", "FLOAT32", "FLOAT64")
_FIELD = _object("foxglove.PackedElementField", name=TEXT, offset=_COUNT, type=_NUMERIC)


FRAME_TRANSFORMS = schema("foxglove.FrameTransforms", transforms=list_of(_TRANSFORM))
SCENE_UPDATE = schema("foxglove.SceneUpdate", deletions=list_of(_DELETION), entities=list_of(_ENTITY))
COMPRESSED_IMAGE = schema("foxglove.CompressedImage", timestamp=_TIME, frame_id=TEXT, data=_BYTES, format=TEXT)
POINT_CLOUD = schema(
    "foxglove.PointCloud",
    timestamp=_TIME,
    frame_id=TEXT,
    pose=_POSE,
    point_stride=_COUNT,
    fields=list_of(_FIELD),
    data=_BYTES,
)
LOG = schema(
    "foxglove.Log",
    timestamp=_TIME,
    level=_one_of("UNKNOWN", "DEBUG", "INFO", "WARNING", "ERROR", "FATAL"),
    message=TEXT,
    name=TEXT,
    file=TEXT,
    line=_COUNT,
)


# ---------------------------------------------------------------------- messages


def stamp(time: float) -> Json:
    """Returns a time [s] as seconds and nanoseconds; there are none before zero."""
    seconds, rest = divmod(max(round(time * 1e9), 0), 1_000_000_000)
    return {"sec": seconds, "nsec": rest}


def pose_json(pose: Pose) -> Json:
    """Returns a pose."""
    return {"position": _vector(pose.position), "orientation": _quaternion(pose.orientation)}


def frame_transforms(time: float, transforms: Iterable[tuple[str, str, Pose]]) -> Json:
    """Returns the poses of frames at a time [s]: the parent, the frame, and its pose in the parent."""
    at = stamp(time)
    return {
        "transforms": [
            {
                "timestamp": at,
                "parent_frame_id": parent,
                "child_frame_id": child,
                "translation": _vector(pose.position),
                "rotation": _quaternion(pose.orientation),
            }
            for parent, child, pose in transforms
        ]
    }


def scene_update(time: float, entities: Sequence[Json], gone: Iterable[str] | None) -> Json:
    """Returns entities that appear or change at a time [s].

    Args:
        time: When.
        entities: See :func:`entity`; their timestamps are set here.
        gone: Ids of those that disappear; None for all that were there before.
    """
    at = stamp(time)
    if gone is None:
        deletions = [{"timestamp": at, "type": _ALL, "id": ""}]
    else:
        deletions = [{"timestamp": at, "type": _MATCHING, "id": name} for name in gone]
    return {"deletions": deletions, "entities": [{"timestamp": at, **one} for one in entities]}


def entity(
    name: str, frame: str, metadata: Mapping[str, str], cubes: Sequence[Json], cylinders: Sequence[Json]
) -> Json:
    """Returns an entity built of boxes and cylinders, fixed to a frame until it is deleted."""
    return {
        "frame_id": frame,
        "id": name,
        "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": True,
        "metadata": [{"key": key, "value": value} for key, value in metadata.items()],
        **dict.fromkeys(_UNUSED, ()),
        "cubes": cubes,
        "cylinders": cylinders,
    }


def cuboid(pose: Pose, size: Sequence[float], color: Sequence[float]) -> Json:
    """Returns a box with lengths along x, y, z [m] around a pose, in a colour (red, green, blue, alpha; 0 to 1)."""
    return {"pose": pose_json(pose), "size": _vector(tuple(size)), "color": _named("rgba", color)}


def cylinder(pose: Pose, radius: float, length: float, color: Sequence[float]) -> Json:
    """Returns a cylinder along z [m] around a pose, in a colour."""
    size = (2.0 * radius, 2.0 * radius, length)
    return {**cuboid(pose, size, color), "bottom_scale": 1.0, "top_scale": 1.0}


def compressed_image(time: float, frame: str, data: bytes, kind: str) -> Json:
    """Returns a picture of a kind ("webp", "jpeg", "png") that a camera took at a time [s]."""
    return {"timestamp": stamp(time), "frame_id": frame, "data": _base64(data), "format": kind}


def point_cloud(time: float, frame: str, points: Array, colours: Array) -> Json:
    """Returns coloured points.

    Args:
        time: When they were measured [s].
        frame: The frame that they are in.
        points: Shape (n, 3) [m].
        colours: Red, green, blue from 0 to 255, shape (n, 3).
    """
    packed = np.zeros(len(points), dtype=[("xyz", "<f4", 3), ("rgba", "u1", 4)])
    packed["xyz"] = np.rint(points * _GRID) / _GRID
    packed["rgba"][:, :3], packed["rgba"][:, 3] = colours, 255
    floats = [{"name": name, "offset": 4 * index, "type": _FLOAT32} for index, name in enumerate("xyz")]
    parts = ("red", "green", "blue", "alpha")
    return {
        "timestamp": stamp(time),
        "frame_id": frame,
        "pose": pose_json(Pose()),
        "point_stride": packed.itemsize,
        "fields": floats + [{"name": name, "offset": 12 + i, "type": _UINT8} for i, name in enumerate(parts)],
        "data": _base64(packed.tobytes()),
    }


def log(time: float, message: str, name: str, level: int = _INFO) -> Json:
    """Returns a line of a log at a time [s]; levels go from 1 (debug) to 5 (fatal)."""
    return {"timestamp": stamp(time), "level": level, "message": message, "name": name, "file": "", "line": 0}


@lru_cache(1024)  # most frames of a robot never move in their parents
def _vector(values: tuple[float, ...]) -> Json:
    return _named("xyz", values)


@lru_cache(1024)
def _quaternion(values: tuple[float, ...]) -> Json:
    return _named("xyzw", values)


def _named(names: str, values: Sequence[float]) -> Json:
    return {name: round(float(value), _DIGITS) for name, value in zip(names, values, strict=True)}


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")
