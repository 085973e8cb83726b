"""The replay of a job as the web page shows it, read from the job's recording."""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Mapping, Sequence
from itertools import groupby, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skiros_py.geometry import Array, Pose
from skiros_py.ports.frames import MAP
from skiros_py.recording.reader import DEVICES, Recording
from skiros_py.station.recordings.sources import VIEW

MOST_FRAMES = 5000
_DIGITS = 5


def replay_text(recording: Recording, *, over: bool) -> bytes:
    """Returns the replay of a job as JSON; see :class:`skiros_py.api.replays.Replay`.

    Args:
        recording: The recording of the job.
        over: Whether the job is over.

    Raises:
        FileError: The recording is damaged.
        ValueError: It has no beginning yet.
    """
    views = list(recording.messages(VIEW.name))
    if not views:
        raise ValueError("it has no beginning")
    runs = {part["run"] for part in recording.parts}
    replay = {
        "job": recording.meta["job"],
        "start": views[0][1],
        "end": recording.end,
        "complete": over and recording.complete and len(runs) == 1 and not recording.left_out,
        "shifts": [
            [part["start"] + part["shift"], part["shift"]]
            for before, part in pairwise(recording.parts)
            if part["shift"] != before["shift"]
        ],
        "beginning": views[0][2]["view"],
        "frames": _frames(recording),
        "changes": [{"time": time, **message} for _, time, message in views[1:]],
    }
    return json.dumps(replay, separators=(",", ":")).encode()


def _frames(recording: Recording) -> dict[str, Any]:
    """Returns the states of the devices at the same times each; a device that is no longer there stays where it was."""
    found = [
        (time, [(channel.topic, message.data) for _, channel, message in group])
        for time, group in groupby(recording.raw_messages(DEVICES), key=lambda one: one[2].log_time)
    ]
    times = np.array([time for time, _ in found]) / 1e9
    kept = _thinned(times)
    present: dict[tuple[str, str], Any] = {}
    tracks: dict[tuple[str, str], list[Any]] = {}
    for number in kept.tolist():
        for topic, data in found[number][1]:
            name, state = topic.removeprefix(DEVICES), json.loads(data)
            known = {(kind, name): read(state) for field, kind, read in _KINDS if field in state}
            present |= known or {("devices", name): state}
        tracks = tracks or {device: [] for device in present}
        for device, track in tracks.items():
            track.append(present[device])
    by_kind: dict[str, dict[str, Any]] = {
        kind: {name: track for (one, name), track in tracks.items() if one == kind} for _, kind, _ in _KINDS
    }
    others = {name: track for (kind, name), track in tracks.items() if kind == "devices"}
    poses = _poses(recording, others, [found[number][0] for number in kept.tolist()])
    by_kind["devices"] = {name: {"states": track, "poses": poses.get(name)} for name, track in others.items()}
    return {"times": np.round(times[kept], _DIGITS).tolist(), **by_kind}


def _poses(recording: Recording, devices: Collection[str], times: Sequence[int]) -> dict[str, list[list[float]]]:
    """Returns the poses in the map of those devices that have frames of their own, at each of some times [ns]."""
    if not devices:
        return {}
    tracks: dict[str, list[list[float]]] = {}
    last: dict[str, list[float]] = {}
    frames = iter([(one.log_time, json.loads(one.data)) for _, _, one in recording.raw_messages("/frames")])
    ahead = next(frames, None)
    for time in times:
        while ahead is not None and ahead[0] <= time:
            for one in ahead[1]["transforms"]:
                if one["parent_frame_id"] == MAP and one["child_frame_id"] in devices:
                    numbers = (*one["translation"].values(), *one["rotation"].values())
                    last[one["child_frame_id"]] = [round(number, _DIGITS) for number in numbers]
            ahead = next(frames, None)
        for name, pose in last.items():
            tracks.setdefault(name, []).append(pose)
    return tracks


def _in_plane(state: Mapping[str, Any]) -> tuple[float, float, float]:
    pose = Pose(tuple(state["pose"]["position"]), tuple(state["pose"]["orientation"]))
    return (*pose.position[:2], round(pose.yaw, _DIGITS))


_KINDS = (
    ("positions", "arms", lambda state: state["positions"]),
    ("gap", "grippers", lambda state: state["gap"]),
    ("pose", "bases", _in_plane),
)
"""By which field of its state a kind of device is known, and what the page shows of it."""


def _thinned(times: Array) -> NDArray[np.int_]:
    """Returns the numbers of the frames that are told: at most so many, evenly spread over the times."""
    kept = np.arange(len(times))
    interval = 0.1
    while len(kept) > MOST_FRAMES:
        interval *= 2.0
        kept = kept[np.diff(np.floor(times[kept] / interval), prepend=-math.inf) > 0]
    return kept
