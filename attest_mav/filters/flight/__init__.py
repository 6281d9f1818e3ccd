"""The parts of the velocity-aided flight filter: what is estimated, how it moves, and what corrects it."""
