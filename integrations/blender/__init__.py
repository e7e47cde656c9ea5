"""Trochoid in Blender: repaints renders by graphs whose pictures cannot leave their palette."""

from . import handlers, operators, panels, properties, repaint

# Properties first: all others use them.
MODULES = [properties, operators, panels, repaint, handlers]


def register():
    for module in MODULES:
        module.register()


def unregister():
    for module in reversed(MODULES):
        module.unregister()
