"""Recordings: one MCAP file for each run or job, with a channel for each topic, that other programs open, too."""

from skiros_py.recording.foxglove import Schema
from skiros_py.recording.reader import Recording, find_recording
from skiros_py.recording.recorder import Recorder
from skiros_py.recording.topic import Topic, own_schema
from skiros_py.recording.writer import RecordingWriter

__all__ = [
    "Recorder",
    "Recording",
    "RecordingWriter",
    "Schema",
    "Topic",
    "find_recording",
    "own_schema",
]
