"""automata."""
