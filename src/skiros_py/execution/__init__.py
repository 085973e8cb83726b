"""The control cycle, running skills and primitives in it, and the managers that offer them."""
