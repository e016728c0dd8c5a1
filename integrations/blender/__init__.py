# SPDX-License-Identifier: GPL-3.0-or-later
"""Afterimage in Blender: a render engine that reuses the samples of the frame before, and an export of shots."""

from . import engine, operators, panels, properties, session

MODULES = (properties, session, engine, operators, panels)


def register():
    """Registers everything, as Blender asks for it."""
    for module in MODULES:
        module.register()


def unregister():
    """Unregisters everything."""
    for module in reversed(MODULES):
        module.unregister()
