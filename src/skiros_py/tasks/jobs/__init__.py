"""Jobs: ordered goals, in a queue, with states after ISA-95 job control, kept over restarts."""

from skiros_py.tasks.jobs.job import (
    Actual,
    Intent,
    Job,
    JobOrder,
    JobState,
    Material,
    MaterialActual,
    Outcome,
    Transition,
    Trigger,
    allowed,
)
from skiros_py.tasks.jobs.manager import JobManager
from skiros_py.tasks.jobs.store import Announcement, JobStore, Page, Receipt

__all__ = [
    "Actual",
    "Announcement",
    "Intent",
    "Job",
    "JobManager",
    "JobOrder",
    "JobState",
    "JobStore",
    "Material",
    "MaterialActual",
    "Outcome",
    "Page",
    "Receipt",
    "Transition",
    "Trigger",
    "allowed",
]
