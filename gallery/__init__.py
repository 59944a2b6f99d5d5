"""One short script a picture: `build()` returns the mesh; run as a script it draws and saves.

`python -m gallery` draws them all into out/gallery.
"""

NAMES = (
    "corner_cutting",
    "koch_snowflake",
    "takagi",
    "patches",
    "sierpinski_tetrahedron",
    "menger_sponge",
    "half_rough",
    "mixed",
    "mixed_surface",
    "vapour",
    "roughness",
)
