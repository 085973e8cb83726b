"""What a running cell offers: use cases that command line, library and server call alike."""
