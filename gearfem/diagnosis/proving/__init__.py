"""Open the records held out."""
