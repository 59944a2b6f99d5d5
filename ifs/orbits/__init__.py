"""Points of an attractor: by chance, by depth, by address."""
