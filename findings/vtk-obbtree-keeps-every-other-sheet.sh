#!/usr/bin/env bash
# VTK 9.5.2 (PyPI): vtkOBBTree.IntersectWithLine.
#
# Three parallel open squares, 1 apart, all facing the same way; a line goes through all three, beside edges.
# Guess: 3 points.
# Seen:  1 point. With the middle square turned round, 3. Hits that enter, one after the other, without a leave
#        between are dropped, as if every mesh were closed, so that leaves, cards and ribbons vanish behind the
#        first. vtkStaticCellLocator gives 3 both times.
. "$(dirname "$0")/lib.sh"
python_with vtk==9.5.2
"$python" - <<'PY'
import vtk
from verdict import verdict

def squares(facing):
    points, cells = vtk.vtkPoints(), vtk.vtkCellArray()
    for level, forward in enumerate(facing):
        corners = [points.InsertNextPoint(x, y, level) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        corners = corners if forward else corners[::-1]
        for triangle in ((0, 1, 2), (0, 2, 3)):
            cells.InsertNextCell(3)
            for corner in triangle:
                cells.InsertCellPoint(corners[corner])
    mesh = vtk.vtkPolyData()
    mesh.SetPoints(points)
    mesh.SetPolys(cells)
    return mesh

START, END = (0.3, 0.1, -5), (0.3, 0.1, 9)

def counts(facing):
    mesh, found = squares(facing), []
    tree, points = vtk.vtkOBBTree(), vtk.vtkPoints()
    tree.SetDataSet(mesh)
    tree.BuildLocator()
    tree.IntersectWithLine(START, END, points, None)
    found.append(points.GetNumberOfPoints())
    locator, points = vtk.vtkStaticCellLocator(), vtk.vtkPoints()
    locator.SetDataSet(mesh)
    locator.BuildLocator()
    locator.IntersectWithLine(START, END, 1e-9, points, vtk.vtkIdList())
    found.append(points.GetNumberOfPoints())
    return found

verdict("points of OBBTree and StaticCellLocator: three squares that face the same way", "3 and 3",
        counts((True, True, True)), [1, 3])
verdict("the middle one turned round", "3 and 3", counts((True, False, True)), [3, 3])
PY
