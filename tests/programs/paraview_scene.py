# A sphere with edges and a cone in a view of ParaView. It runs in Python's own process, because pvbatch has no window.
# scripts/compat runs it.
from paraview.simple import Cone, GetActiveView, Render, Show, Sphere

Show(Sphere()).SetRepresentationType("Surface With Edges")
Show(Cone(Center=[1, 0, 0]))
view = GetActiveView()
view.ViewSize = [400, 400]
Render()
view.CameraPosition = [0, 0, 3]
view.CameraViewAngle = 90
while True:
    Render()
