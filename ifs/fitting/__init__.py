"""Control points and coefficients from data."""
