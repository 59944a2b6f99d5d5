"""The colours of all pictures."""

PAPER = "#fbfaf6"
INK = "#1f4e6b"
CLAY = "#8dbad6"  # surfaces and solids
WIRE = "#c8743a"  # curves in space
