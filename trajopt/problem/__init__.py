"""Problems: goals, requirements, costs and constraints of a motion."""
