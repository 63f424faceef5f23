"""Geometry that every algorithm here builds on."""
