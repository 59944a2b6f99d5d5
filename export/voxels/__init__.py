"""Voxels that cover an attractor, with certificates, and predictions of what they take."""
