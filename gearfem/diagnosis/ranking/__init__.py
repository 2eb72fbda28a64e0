"""Rank effects by what each would explain."""
