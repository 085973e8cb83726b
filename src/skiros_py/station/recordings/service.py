"""Use cases: the recordings of jobs, as files and as replays."""

from __future__ import annotations

import math
from pathlib import Path

from skiros_py.errors import FileError, Refused
from skiros_py.station.recordings.replay import replay_text
from skiros_py.station.requests import Service
from skiros_py.tasks.jobs import Job


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
