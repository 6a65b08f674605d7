"""Planning among dynamic obstacles: by waiting, retiming, detours, or in space and time."""
