"""Planning among things that move, appear and expire: later, timed anew, around, or in space and time."""
