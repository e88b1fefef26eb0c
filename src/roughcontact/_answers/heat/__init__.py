"""Heat of sliding: temperature by moving sources, and its partition between both bodies."""
