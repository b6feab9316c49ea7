# Points and a grid in a turntable view of vispy. vispy clips by gl_FragCoord. scripts/compat runs it.
import numpy
from vispy import app, scene

app.use_app("glfw")
canvas = scene.SceneCanvas(size=(400, 400), show=True)
view = canvas.central_widget.add_view()
view.camera = scene.TurntableCamera(fov=70, distance=4, elevation=10)
random = numpy.random.default_rng(1)
scene.visuals.Markers(pos=random.normal(size=(500, 3)), face_color=random.uniform(size=(500, 3)), parent=view.scene)
scene.visuals.GridLines(parent=view.scene)
scene.visuals.XYZAxis(parent=view.scene)
timer = app.Timer("auto", connect=lambda event: canvas.update(), start=True)
app.run()
