"""Jobs: ordered goals, in a queue, with states after ISA-95 job control, kept over restarts."""
