"""The server's operations, one module per topic: functions that create a :class:`Call` without sending it."""
