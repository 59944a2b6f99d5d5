"""Files of parts, scenes, sets of cells and layers, written whole or not at all."""
