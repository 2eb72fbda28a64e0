"""Fit a problem: its objective, steps, starts, and explanations that have been fitted."""
