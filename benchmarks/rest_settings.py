"""What the processes of the REST benchmark agree on."""

SCENE = "kitting"
JOB = "kitting-job"
GOAL = "InKit(Starter, kit_1) and InKit(Alternator, kit_1) and InKit(Compressor, kit_1)"
"""What the job is for; the same as the scene's own goal in what has to be done."""
