"""What can be asked of a server, one module for each topic: functions that make a :class:`Call`, and send nothing."""
