"""Plain Python twins of the native cores, written for clarity: what the compiled code is compared with."""
