"""Points moved by a transform file as 3D Slicer hangs data under it: by the inverse of what ITK reads.

move_points.py FILE POINTS.csv prints one list of numbers a point, as JSON.
"""

import json
import sys

import numpy as np
import SimpleITK as itk

file, points = sys.argv[1:]
to_parent = itk.ReadTransform(file).GetInverse()
rows = np.loadtxt(points, delimiter=",", ndmin=2)
json.dump([to_parent.TransformPoint(row) for row in rows], sys.stdout)
