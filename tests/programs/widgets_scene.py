# A scene between widgets of Qt: cubes around the camera, a list at the left, a menu above. scripts/compat runs it.
import sys

from OpenGL import GL
from OpenGL.GLU import gluPerspective
from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QSurfaceFormat
from PySide6.QtOpenGLWidgets import QOpenGLWidget
from PySide6.QtWidgets import QApplication, QDockWidget, QListWidget, QMainWindow

SIDES = [((1, 0, 0), "yz"), ((-1, 0, 0), "yz"), ((0, 1, 0), "zx"), ((0, -1, 0), "zx"), ((0, 0, 1), "xy"), ((0, 0, -1), "xy")]


def cube():
    GL.glBegin(GL.GL_QUADS)
    for normal, (first, second) in SIDES:
        GL.glNormal3f(*normal)
        for across, up in [(-1, -1), (1, -1), (1, 1), (-1, 1)]:
            corner = dict(zip("xyz", normal)) | {first: across, second: up}
            GL.glVertex3f(corner["x"], corner["y"], corner["z"])
    GL.glEnd()


class Scene(QOpenGLWidget):
    turn = 0.0

    def paintGL(self):
        GL.glClearColor(0.5, 0.7, 0.9, 1)
        GL.glClear(GL.GL_COLOR_BUFFER_BIT | GL.GL_DEPTH_BUFFER_BIT)
        for capability in (GL.GL_DEPTH_TEST, GL.GL_LIGHTING, GL.GL_LIGHT0, GL.GL_COLOR_MATERIAL, GL.GL_NORMALIZE):
            GL.glEnable(capability)
        GL.glMatrixMode(GL.GL_PROJECTION)
        GL.glLoadIdentity()
        gluPerspective(70, self.width() / self.height(), 0.1, 100)
        GL.glMatrixMode(GL.GL_MODELVIEW)
        GL.glLoadIdentity()
        GL.glRotatef(self.turn, 0, 1, 0)
        GL.glPushMatrix()
        GL.glTranslatef(0, -3, 0)
        GL.glScalef(40, 0.1, 40)
        GL.glColor3f(0.2, 0.5, 0.2)
        cube()
        GL.glPopMatrix()
        for number in range(12):
            GL.glPushMatrix()
            GL.glRotatef(30 * number, 0, 1, 0)
            GL.glTranslatef(0, number % 3, -8)
            GL.glColor3f(number / 12, 1 - number / 12, (number % 4) / 3)
            cube()
            GL.glPopMatrix()

    def step(self):
        self.turn += 0.5
        self.update()


plain = QSurfaceFormat()
plain.setDepthBufferSize(24)
QSurfaceFormat.setDefaultFormat(plain)
application = QApplication(sys.argv)
window = QMainWindow()
scene = Scene()
window.setCentralWidget(scene)
window.menuBar().addMenu("File")
names = QListWidget()
names.addItems(["north", "east", "south", "west"])
names.setMaximumWidth(90)
dock = QDockWidget("Places")
dock.setWidget(names)
window.addDockWidget(Qt.DockWidgetArea.LeftDockWidgetArea, dock)
window.resize(400, 400)
window.show()
timer = QTimer()
timer.timeout.connect(scene.step)
timer.start(16)
sys.exit(application.exec())
