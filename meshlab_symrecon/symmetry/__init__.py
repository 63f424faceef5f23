"""Reflection planes of incomplete clouds, and completion by mirroring."""
