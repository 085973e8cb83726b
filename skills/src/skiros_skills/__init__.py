"""The built-in skills and conditions for kitting. Found through entry points."""
