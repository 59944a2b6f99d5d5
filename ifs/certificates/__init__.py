"""How far an attractor reaches, and the proof that it exists."""
