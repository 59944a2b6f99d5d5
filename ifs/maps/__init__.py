"""Affine and projective maps, and the plain systems that they make."""
