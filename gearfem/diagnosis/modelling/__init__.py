"""What records would read: the model, nuisances, single teeth and errors of the model, and their columns."""
