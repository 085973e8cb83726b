"""What goes over the wire: the data that server and client share, one module for each topic."""
