"""The world as the API shows it."""
