"""The search for a proof that holds at all times."""
