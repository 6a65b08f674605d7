"""What MoveIt's move_group node does: planning, executing and reporting, for the server and the commander."""
