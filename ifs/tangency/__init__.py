"""Points at parameters, tangents and normals of limit surfaces and curves."""
