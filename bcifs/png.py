"""PNG files with the recipe in their text."""

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING

from export.formats.atomic import whole_file

if TYPE_CHECKING:
    from PIL.Image import Image


def write_png(picture: "Image", path: str | os.PathLike[str], recipe: Mapping[str, str]) -> None:
    """Write a picture; each entry of the recipe becomes a text of the file. Whole or not at all."""
    from PIL.PngImagePlugin import PngInfo

    texts = PngInfo()
    texts.add_text("Software", "bcifs")
    for key, value in recipe.items():
        texts.add_itxt(f"bcifs:{key}"[:79], value)
    with whole_file(path) as file:
        picture.save(file, "PNG", pnginfo=texts)
