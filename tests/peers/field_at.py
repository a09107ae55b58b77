"""A displacement field as another program reads it, at points in the file's own frame.

field_at.py READER FILE POINTS.csv prints one list of numbers a point, as JSON.
"""

import itertools
import json
import sys

import numpy as np


def of_nrrd(file):
    import nrrd

    values, header = nrrd.read(file)
    assert header["space"] == "left-posterior-superior", header["space"]
    assert header["kinds"] == ["vector", "domain", "domain", "domain"], header["kinds"]
    steps = np.array(header["space directions"], dtype=float)[1:]
    return lattice(np.moveaxis(values, 0, -1), header["space origin"], steps)


def of_itk(file):
    """As 3D Slicer does: an image that becomes a transform, which moves points."""
    import SimpleITK as itk

    field = itk.DisplacementFieldTransform(itk.ReadImage(file, itk.sitkVectorFloat64))
    return lambda point: np.array(field.TransformPoint(point)) - point


def of_vtk(file, name="error_mm"):
    """VTK's own reader, which ParaView has."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLImageDataReader

    reader = vtkXMLImageDataReader()
    reader.SetFileName(file)
    reader.Update()
    image = reader.GetOutput()
    values = vtk_to_numpy(image.GetPointData().GetArray(name))
    values = values.reshape(*image.GetDimensions()[::-1], -1).transpose(2, 1, 0, 3)
    return lattice(values, image.GetOrigin(), np.diag(image.GetSpacing()))


def lattice(values, origin, steps):
    """Linear between the points of a lattice; `values` has its index first, `steps` a row an axis."""
    last = np.array(values.shape[:3]) - 1
    index_from_space = np.linalg.inv(np.array(steps, dtype=float).T)

    def at(point):
        index = np.clip(index_from_space @ (np.array(point) - origin), 0, last)
        low = np.minimum(np.floor(index), np.maximum(last - 1, 0)).astype(int)
        part = index - low
        total = 0.0
        for corner in itertools.product((0, 1), repeat=3):
            weight = np.prod(np.where(corner, part, 1 - part))
            place = np.minimum(low + corner, last)
            total = total + weight * values[tuple(place)]
        return total

    return at


READERS = {
    "pynrrd": of_nrrd,
    "itk": of_itk,
    "vtk": of_vtk,
    "vtk-angle": lambda file: of_vtk(file, "error_angle_deg"),
}

reader, file, points = sys.argv[1:]
field = READERS[reader](file)
rows = np.loadtxt(points, delimiter=",", ndmin=2)
json.dump([np.atleast_1d(field(row)).tolist() for row in rows], sys.stdout)
