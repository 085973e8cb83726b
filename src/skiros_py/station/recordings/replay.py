"""Use cases: the recordings of jobs, as files and as replays."""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Mapping, Sequence
from itertools import groupby, islice, pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skiros_py.errors import FileError, Refused
from skiros_py.geometry import Array, Pose
from skiros_py.ports.frames import MAP
from skiros_py.recording.reader import DEVICES, Recording
from skiros_py.station.recordings.sources import VIEW
from skiros_py.station.requests import Service
from skiros_py.tasks.jobs import Job

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
    views = [(began, beginning), *((time, one) for _, time, one in later if time <= end or one["anew"])]
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
        if change["anew"]:
            elements.clear()
        for name in view["gone"]:
            elements.pop(name, None)
        elements |= {element["id"]: element for element in view["elements"]}
        shapes |= view["shapes"]
    return {**changes[-1]["view"], "elements": list(elements.values()), "shapes": shapes, "gone": []}


def _frames(recording: Recording, start: float, end: float) -> dict[str, Any]:
    """Returns the states of all devices at common times.

    Includes the last frame before the range and the first one after it. A device that has disappeared keeps its last
    state.
    """
    if start > recording.start:
        start = recording.frame(start).time
    found = []
    for time, group in groupby(recording.raw_messages(DEVICES, start=start), key=lambda one: one[2].log_time):
        found.append((time, [(channel.topic, message.data) for _, channel, message in group]))
        if time > end * 1e9:
            break
    times = np.array([time for time, _ in found]) / 1e9
    kept = _thinned(times)
    present: dict[tuple[str, str], Any] = {}
    tracks: dict[tuple[str, str], list[Any]] = {}
    for number in kept.tolist():
        for topic, data in found[number][1]:
            name, state = topic.removeprefix(DEVICES), json.loads(data)
            known = {(kind, name): state[field] for field, kind in _KINDS if field in state}
            present |= known or {("devices", name): state}
        tracks = tracks or {device: [] for device in present}
        for device, track in tracks.items():
            track.append(present[device])
    by_kind: dict[str, dict[str, Any]] = {
        kind: {name: track for (one, name), track in tracks.items() if one == kind} for _, kind in _KINDS
    }
    by_kind["bases"] = {}
    others = {name: track for (kind, name), track in tracks.items() if kind == "devices"}
    poses = _poses(recording, others, [found[number][0] for number in kept.tolist()])
    moving = [name for name, track in others.items() if "pose" in track[0] and (name in poses or not poses)]
    for name in moving:  # bases: where they were localised, else where their odometry was
        own = [(*one["pose"]["position"], *one["pose"]["orientation"]) for one in others.pop(name)]
        by_kind["bases"][name] = [_in_plane(row) for row in poses.get(name, own)]
    by_kind["devices"] = {name: {"states": track, "poses": poses.get(name)} for name, track in others.items()}
    return {"times": np.round(times[kept], _DIGITS).tolist(), **by_kind}


def _poses(recording: Recording, devices: Collection[str], times: Sequence[int]) -> dict[str, list[list[float]]]:
    """Returns the poses in the map of the devices that have their own frames, at each of the times [ns]."""
    if not devices:
        return {}
    tracks: dict[str, list[list[float]]] = {}
    last: dict[str, list[float]] = {}
    written = recording.raw_messages("/frames", start=times[0] / 1e9, end=times[-1] / 1e9)
    frames = ((one.log_time, json.loads(one.data)) for _, _, one in written)
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


def _in_plane(numbers: Sequence[float]) -> tuple[float, float, float]:
    x, y, _, *orientation = numbers
    qx, qy, qz, qw = orientation
    return x, y, round(Pose(orientation=(qx, qy, qz, qw)).yaw, _DIGITS)


_KINDS = (
    ("positions", "arms"),
    ("gap", "grippers"),
)
"""The field by which the state of an arm or gripper is recognised: the data to show of it."""


def _thinned(times: Array) -> NDArray[np.int_]:
    """Returns the indices of the frames to include: limited in number, and evenly spread over the times."""
    kept = np.arange(len(times))
    interval = 0.1
    while len(kept) > MOST_FRAMES:
        interval *= 2.0
        kept = kept[np.diff(np.floor(times[kept] / interval), prepend=-math.inf) > 0]
    return kept


class RecordingService(Service):
    """Finds the recordings of jobs."""

    def path(self, job: str) -> Path:
        """Returns the path of the recording of a job, an MCAP file.

        Raises:
            UnknownName: There is no such job.
            Refused: It is not recorded, or its recording was deleted.
        """
        known = self._station.session.jobs.job(job)
        path = self._station.job_recordings.path(known.number)
        if not path.is_file():
            raise _no_replay(known, FileError(path, "there is no such recording"))
        return path

    def replay(self, job: str, start: float = -math.inf, end: float = math.inf) -> bytes:
        """Returns the replay of a job, or of a range of it, as JSON.

        Args:
            job: Id of the job.
            start: Start of the range [s, run time].
            end: End of the range [s].

        Raises:
            UnknownName: There is no such job.
            Refused: It is not recorded, or its recording was deleted.
        """
        known = self._station.session.jobs.job(job)
        try:
            with self._station.job_recordings.read(known.number) as recording:
                return replay_text(recording, over=not known.state.is_open, start=start, end=end)
        except (FileError, ValueError, KeyError) as error:
            raise _no_replay(known, error) from None


def _no_replay(job: Job, error: Exception) -> Refused:
    if job.started is None:
        why = "it has not begun" if job.state.is_open else "it never began"
    elif job.state.is_open:
        why = "nothing is written down yet: ask again in some seconds"
    else:
        why = f"it is kept no longer, or never was ({error}): there is room for those of the last jobs only"
    return Refused("NoReplay", f"there is no replay of job '{job.id}': {why}")
