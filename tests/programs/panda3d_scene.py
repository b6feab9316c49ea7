# Cards and models of Panda3D around the camera, with shaders that Panda3D generates. scripts/compat runs it.
import math
import sys

from direct.showbase.ShowBase import ShowBase
from panda3d.core import AmbientLight, CardMaker, DirectionalLight, loadPrcFileData

loadPrcFileData("", "win-size 400 400\naudio-library-name null")
base = ShowBase()
base.disableMouse()
base.camLens.setFov(100)
base.setBackgroundColor(0.1, 0.2, 0.4)
for i in range(12):
    angle = i * math.pi / 6
    model = base.loader.loadModel("models/smiley") if i % 2 else base.render.attachNewNode(CardMaker("card").generate())
    model.reparentTo(base.render)
    model.setTwoSided(True)
    model.setPos(6 * math.sin(angle), 6 * math.cos(angle), i % 3 - 1)
    model.setColor(i % 2, 0.3 + i % 3 / 3, 0.7, 1)
for light in (AmbientLight("ambient"), DirectionalLight("sun")):
    base.render.setLight(base.render.attachNewNode(light))
if "auto" in sys.argv:
    base.render.setShaderAuto()
base.run()
