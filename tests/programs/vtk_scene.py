# A ring of spheres with edges around the camera of VTK, a gradient as background and a text. scripts/compat runs it.
import math

import vtkmodules.vtkRenderingFreeType  # noqa: F401
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow, vtkTextActor

renderer = vtkRenderer()
renderer.GradientBackgroundOn()
renderer.SetBackground(0.1, 0.2, 0.6)
renderer.SetBackground2(0.9, 0.8, 0.3)
window = vtkRenderWindow()
window.SetSize(400, 400)
window.AddRenderer(renderer)
for i in range(12):
    sphere = vtkSphereSource()
    sphere.SetThetaResolution(12)
    angle = i * math.pi / 6
    sphere.SetRadius(1)
    sphere.SetCenter(6 * math.sin(angle), i % 3 - 1, -6 * math.cos(angle))
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(sphere.GetOutputPort())
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(i % 2, 0.3 + i % 3 / 3, 0.7)
    actor.GetProperty().EdgeVisibilityOn()
    renderer.AddActor(actor)
text = vtkTextActor()
text.SetInput("A text")
text.GetTextProperty().SetFontSize(30)
text.SetPosition(20, 20)
renderer.AddViewProp(text)
camera = renderer.GetActiveCamera()
camera.SetPosition(0, 0, 0)
camera.SetFocalPoint(0, 0, -1)
camera.SetViewAngle(100)
renderer.ResetCameraClippingRange()
while True:
    window.Render()
