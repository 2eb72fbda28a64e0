"""Search for explanations, and name them where they have earned it."""
