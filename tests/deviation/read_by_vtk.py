"""What VTK, which ParaView reads by, finds in a GLB, as JSON: read_by_vtk.py FILE"""
import json
import sys

from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOGeometry import vtkGLTFReader

reader = vtkGLTFReader()
reader.SetFileName(sys.argv[1])
reader.Update()
output = reader.GetOutput()
blocks = output.NewIterator()
blocks.InitTraversal()
found = None
while not blocks.IsDoneWithTraversal():
    block = blocks.GetCurrentDataObject()
    if block.GetNumberOfPolys() > 0:
        found = block
    blocks.GoToNextItem()
data = found.GetPointData()
names = [data.GetArrayName(i) for i in range(data.GetNumberOfArrays())]
scalar = next(name for name in names if name.upper() == "_DISTANCE")
colour = next(name for name in names if name.upper() == "COLOR_0")
polys = vtk_to_numpy(found.GetPolys().GetConnectivityArray()).reshape(-1, 3)
json.dump({"positions": vtk_to_numpy(found.GetPoints().GetData()).tolist(), "triangles": polys.tolist(),
           "quality": vtk_to_numpy(data.GetArray(scalar)).tolist(),
           "colours": vtk_to_numpy(data.GetArray(colour))[:, :3].tolist()}, sys.stdout)
