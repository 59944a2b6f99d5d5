"""The command `fld`: what a curve or a surface does at a point, in words, as JSON and as pictures."""
