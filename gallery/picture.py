"""Where the pictures of the gallery go."""

from importlib.metadata import version
from pathlib import Path

from ifs import Mesh

FOLDER = Path("out") / "gallery"


def save(name: str, mesh: Mesh) -> Path:
    """Draw a mesh into `out/gallery/NAME.png` and say so."""
    from bcifs.picture import draw_mesh

    FOLDER.mkdir(parents=True, exist_ok=True)
    path = FOLDER / f"{name}.png"
    draw_mesh(mesh, path, {"name": name, "gallery": f"gallery/{name}.py", "bcifs": version("bcifs")})
    print(path)
    return path
