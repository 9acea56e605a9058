"""Integrators, one step at a time, with dense output."""
