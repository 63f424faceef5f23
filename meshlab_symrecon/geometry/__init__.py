"""Geometry that every algorithm here builds on: planes, bounds, neighbours, sampling, triangulation."""
