# Boxes around the camera of pygfx, which draws with wgpu. scripts/compat runs it.
import math

import pygfx
from rendercanvas.glfw import RenderCanvas, loop

canvas = RenderCanvas(size=(400, 400), update_mode="continuous")
renderer = pygfx.renderers.WgpuRenderer(canvas)
scene = pygfx.Scene()
scene.add(pygfx.Background.from_color("#345"), pygfx.AmbientLight(), pygfx.DirectionalLight())
for i in range(12):
    box = pygfx.Mesh(pygfx.box_geometry(1, 1 + i % 3, 1), pygfx.MeshPhongMaterial(color=(i % 2, 0.3 + i % 3 / 3, 0.7)))
    angle = i * math.pi / 6
    box.local.position = (5 * math.sin(angle), 0, -5 * math.cos(angle))
    scene.add(box)
camera = pygfx.PerspectiveCamera(100, 1, depth_range=(0.1, 100))
canvas.request_draw(lambda: renderer.render(scene, camera))
loop.run()
