"""Compare records with the model: nuisances alone, row by row and in the means over the pitches."""
