"""The limit surfaces of control meshes."""
