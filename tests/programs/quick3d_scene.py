# A stretched floor and models around the camera of Qt Quick 3D. scripts/compat runs it.
import sys

from PySide6.QtCore import QByteArray, QUrl
from PySide6.QtGui import QGuiApplication
from PySide6.QtQml import QQmlApplicationEngine

SCENE = b"""
import QtQuick
import QtQuick3D
Window {
    width: 400; height: 400; visible: true
    View3D {
        anchors.fill: parent
        environment: SceneEnvironment { clearColor: "skyblue"; backgroundMode: SceneEnvironment.Color }
        PerspectiveCamera { id: camera; y: 150; fieldOfView: 90; clipFar: 10000 }
        DirectionalLight { eulerRotation.x: -40; eulerRotation.y: 30 }
        Model { source: "#Cube"; y: -10; scale: Qt.vector3d(40, 0.1, 40); materials: PrincipledMaterial { baseColor: "green" } }
        Repeater3D { model: 12
            Model { source: index % 2 ? "#Cube" : "#Sphere"
                x: 400 * Math.sin(index * Math.PI / 6); y: 100; z: -400 * Math.cos(index * Math.PI / 6)
                scale: Qt.vector3d(1, 1 + index % 3, 1)
                materials: PrincipledMaterial { baseColor: Qt.hsva(index / 12, 0.8, 0.9, 1) } } }
        NumberAnimation { target: camera; property: "eulerRotation.x"; to: -20; duration: 4000; running: true }
    }
}
"""
application = QGuiApplication(sys.argv)
engine = QQmlApplicationEngine()
engine.loadData(QByteArray(SCENE), QUrl("file:///scene.qml"))
sys.exit(application.exec() if engine.rootObjects() else 1)
