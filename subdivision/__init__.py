"""subdivision."""
