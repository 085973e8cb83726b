"""Jobs: goals that somebody ordered, in a queue, with states after ISA-95 job control, kept over restarts."""

from skiros_py.tasks.jobs.job import Actual, Job, JobOrder, Outcome
from skiros_py.tasks.jobs.manager import JobManager
from skiros_py.tasks.jobs.states import JobState, Trigger
from skiros_py.tasks.jobs.store import JobStore

__all__ = ["Actual", "Job", "JobManager", "JobOrder", "JobState", "JobStore", "Outcome", "Trigger"]
