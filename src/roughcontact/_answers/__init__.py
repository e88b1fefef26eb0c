"""Area estimators and responses: numbers of a solution, each with its uncertainty."""
