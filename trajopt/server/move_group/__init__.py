"""The functions of MoveIt's move_group node: planning, execution and reporting, for server and commander."""
