"""The kinds of device that come along, a file each; the core finds them by entry points, like anyone's."""
