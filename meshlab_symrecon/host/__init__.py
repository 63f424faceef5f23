"""The only door to pymeshlab."""
