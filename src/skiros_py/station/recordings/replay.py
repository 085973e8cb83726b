"""Replays: the recording of a job as the web page plays it."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from itertools import groupby, islice, pairwise
from typing import Any

import numpy as np
from mcap.records import Message
from numpy.typing import NDArray

from skiros_py.geometry import Array, Pose
from skiros_py.ports.frames import MAP
from skiros_py.recording.reader import DEVICES, FRAMES, JOINTS, Recording
from skiros_py.station.recordings.topics import VIEW

MOST_FRAMES = 5000
_DIGITS = 5


def replay_text(recording: Recording, *, over: bool, start: float = -math.inf, end: float = math.inf) -> bytes:
    """Returns the replay of a job as JSON; see :class:`skiros_py.api.view.Replay`.

    Args:
        recording: The recording of the job.
        over: Whether the job is over.
        start: Start of the range whose frames and changes it contains [s, run time].
        end: End of that range [s].

    Raises:
        FileError: The recording is damaged.
        ValueError: It has no initial state yet.
    """
    frames = _frames(recording, start, end)
    until = max([end, *frames["times"][-1:]])
    _, began, beginning = next(recording.messages(VIEW.name), ("", 0.0, None))
    if beginning is None:
        raise ValueError("it has no beginning")
    later = islice(recording.messages(VIEW.name, end=until), 1, None)
    views = [(began, beginning), *((time, one) for _, time, one in later if time <= end or one["whole"])]
    before = max(sum(time <= start for time, _ in views), 1)
    runs = {part["run"] for part in recording.parts}
    replay = {
        "job": recording.meta["job"],
        "start": began,
        "end": recording.end,
        "complete": over and recording.complete and len(runs) == 1 and not recording.left_out,
        "shifts": [
            [part["start"] + part["shift"], part["shift"]]
            for before, part in pairwise(recording.parts)
            if part["shift"] != before["shift"]
        ],
        "beginning": _world_after([message for _, message in views[:before]]),
        "frames": frames,
        "changes": [{"time": time, **message} for time, message in views[before:]],
    }
    return json.dumps(replay, separators=(",", ":")).encode()


def _world_after(changes: Sequence[Mapping[str, Any]]) -> Mapping[str, Any]:
    """Returns the view of the whole world after the changes, with all shapes that they contain."""
    elements: dict[str, Any] = {}
    shapes: dict[str, Any] = {}
    for change in changes:
        view = change["view"]
        if change["whole"]:
            elements.clear()
        for name in view["gone"]:
            elements.pop(name, None)
        elements |= {element["id"]: element for element in view["elements"]}
        shapes |= view["shapes"]
    return {**changes[-1]["view"], "elements": list(elements.values()), "shapes": shapes, "gone": []}


def _frames(recording: Recording, start: float, end: float) -> dict[str, Any]:
    """Returns joints, frames and states of all devices at common times; see :class:`skiros_py.api.view.ReplayFrames`.

    Includes the last frame before the range and the first one after it. A device that has disappeared keeps its last
    state.
    """
    if start > recording.start:
        start = recording.frame(start).time
    moments = []
    for time, _ in groupby(recording.raw_messages(JOINTS, start=start), key=_log_time):
        moments.append(time)
        if time > end * 1e9:
            break
    times = np.array(moments) / 1e9
    kept = _thinned(times)
    wanted = {moments[number] for number in kept}
    present: dict[str, dict[str, Any]] = {"joints": {}, "frames": {}, "states": {}}
    tracks: dict[str, dict[str, list[Any]]] = {}
    messages = recording.raw_messages(JOINTS, FRAMES, DEVICES, start=start, end=max(times, default=start))
    for time, group in groupby(messages, key=_log_time):
        if time not in wanted:
            continue
        for _, channel, message in group:
            data = json.loads(message.data)
            if channel.topic == JOINTS:
                present["joints"] |= data
            elif channel.topic == FRAMES:
                present["frames"] |= _device_poses(data["transforms"])
            else:
                present["states"][channel.topic.removeprefix(DEVICES)] = data
        tracks = tracks or {kind: {name: [] for name in values} for kind, values in present.items()}
        for kind, by_name in tracks.items():
            for name, track in by_name.items():
                track.append(present[kind][name])
    return {"times": np.round(times[kept], _DIGITS).tolist(), **(tracks or present)}


def _log_time(message: tuple[Any, Any, Message]) -> int:
    return message[2].log_time


def _device_poses(transforms: Sequence[Mapping[str, Any]]) -> dict[str, list[float]]:
    """Returns the poses in the map of the frames of devices: x, y, z [m] and a quaternion."""
    parents = {one["child_frame_id"]: one for one in transforms}

    def pose(name: str) -> Pose:
        one = parents[name]
        own = Pose((*one["translation"].values(),), (*one["rotation"].values(),))
        return own if one["parent_frame_id"] == MAP else pose(one["parent_frame_id"]) @ own

    devices = {name: pose(name) for name in parents if "/" not in name}  # names of links have a slash
    return {
        name: [round(number, _DIGITS) for number in (*one.position, *one.orientation)] for name, one in devices.items()
    }


def _thinned(times: Array) -> NDArray[np.int_]:
    """Returns the indices of the frames to include: limited in number, and evenly spread over the times."""
    kept = np.arange(len(times))
    interval = 0.1
    while len(kept) > MOST_FRAMES:
        interval *= 2.0
        kept = kept[np.diff(np.floor(times[kept] / interval), prepend=-math.inf) > 0]
    return kept
