"""Where the pictures of the gallery go."""

from importlib.metadata import version
from pathlib import Path

from export.vapour import Vapour
from fld.roughness import Roughness
from ifs import Mesh

FOLDER = Path("out") / "gallery"


def save(name: str, made: Mesh | Vapour | Roughness) -> Path:
    """Draw a mesh, a cloud or a map of roughness into `out/gallery/NAME.png` and say so."""
    from bcifs.behaviours.roughness import draw_roughness
    from bcifs.cloud import write_cloud
    from bcifs.picture import draw_mesh

    FOLDER.mkdir(parents=True, exist_ok=True)
    path = FOLDER / f"{name}.png"
    recipe = {"name": name, "gallery": f"gallery/{name}.py", "bcifs": version("bcifs")}
    if isinstance(made, Roughness):
        draw_roughness(made, path, recipe)
    elif isinstance(made, Vapour):
        write_cloud(made.density, path, recipe | dict(made.recipe))
    else:
        draw_mesh(made, path, recipe)
    print(path)
    return path
