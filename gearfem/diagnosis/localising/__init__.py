"""Say where the gap is."""
