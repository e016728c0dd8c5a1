# SPDX-License-Identifier: GPL-3.0-or-later
"""Export of a scene as a shot of Afterimage: a shot file, meshes and pictures in a folder."""

from .shot import Exported, Settings, export_shot, run_of, with_camera
from .warnings import Cancelled, ExportError

__all__ = ["Cancelled", "Exported", "ExportError", "Settings", "export_shot", "run_of", "with_camera"]
