"""Pictures of clouds, meshes and mirror planes: a small renderer, and the picture of the main job."""
