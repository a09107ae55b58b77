"""A scene as trimesh reads it: each surface with its name, where it is and what colour it has.

read_glb.py FILE prints JSON: of each node with triangles its name, the least and the greatest corner
in the file's own frame, how many triangles it has, its vertex colours (linear RGBA from 0 to 1, some
of them) or its material's base colour (linear RGBA).
"""

import json
import sys

import numpy as np
import trimesh



def fractions(colors):
    """From 0 to 1, however they are kept."""
    colors = np.asarray(colors)
    whole = np.issubdtype(colors.dtype, np.integer)
    return (colors / np.iinfo(colors.dtype).max if whole else colors).tolist()


scene = trimesh.load_scene(sys.argv[1], process=False)
found = []
for node in scene.graph.nodes_geometry:
    matrix, name = scene.graph[node]
    mesh = scene.geometry[name]
    if not isinstance(mesh, trimesh.Trimesh):
        continue
    corners = trimesh.transform_points(mesh.vertices, matrix)
    entry = {
        "name": node,
        "min": corners.min(axis=0).tolist(),
        "max": corners.max(axis=0).tolist(),
        "triangles": len(mesh.faces),
    }
    if mesh.visual.kind == "texture":
        factor = mesh.visual.material.baseColorFactor
        entry["base_color"] = None if factor is None else fractions(factor)
    colors = mesh.visual.vertex_attributes.get("color") if mesh.visual.kind == "texture" else None
    if colors is None and mesh.visual.kind == "vertex":
        colors = mesh.visual.vertex_colors
    if colors is not None:
        entry["corners"] = corners[::50].tolist()
        entry["colors"] = fractions(colors[::50])
    found.append(entry)
json.dump(found, sys.stdout)
