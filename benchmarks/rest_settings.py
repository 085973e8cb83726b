"""Constants shared by the processes of the REST benchmark."""

SCENE = "kitting"
JOB = "kitting-job"
GOAL = "InKit(Starter, kit_1) and InKit(Alternator, kit_1) and InKit(Compressor, kit_1)"
"""Goal of the job, equivalent to that of the scene."""
