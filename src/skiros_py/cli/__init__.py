"""The command line: ``skiros run``, ``plan``, ``skills``, ``scene``. Heavy imports happen inside the commands."""
