"""Jobs: ordered goals, in a queue, with states after ISA-95 job control, kept over restarts."""

from skiros_py.tasks.jobs.announcements import Announcement
from skiros_py.tasks.jobs.job import Actual, Intent, Job, MaterialActual, Outcome, Transition
from skiros_py.tasks.jobs.manager import JobManager
from skiros_py.tasks.jobs.order import JobOrder, Material
from skiros_py.tasks.jobs.receipts import Receipt
from skiros_py.tasks.jobs.states import JobState, Trigger, allowed
from skiros_py.tasks.jobs.store import JobStore, Page

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
