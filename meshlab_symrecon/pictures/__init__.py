"""Pictures of clouds, meshes and mirror planes, drawn in numpy."""
