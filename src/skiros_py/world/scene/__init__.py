"""Scene files: reading, writing, comparing and replacing a world's scene; learned data has a similar file."""
