"""Triangle meshes and the convex shapes that cover them."""
