# SPDX-License-Identifier: GPL-3.0-or-later
"""Linked data that is not there: Blender has placeholders for it, which show nothing."""

import bpy


def tell_of_missing(warnings):
    """Says of each linked file what of it is missing: all of it, or what it does not hold any more."""
    for library in bpy.data.libraries:
        lost = [one for one in library.users_id if one.is_missing]
        if not lost:
            continue
        path = bpy.path.abspath(library.filepath)
        named = ", ".join(f"{one.id_type.replace('_', ' ').lower()} `{one.name}`" for one in lost[:3])
        if len(lost) > 3:
            named += f" and {len(lost) - 3} more"
        if library.is_missing:
            warnings.add(f"the linked file `{path}` is missing, and with it {named}: left out. File > External Data > Find Missing Files")
        else:
            warnings.add(f"the linked file `{path}` has no {named} any more: left out. Link it again, or remove what stands for it")
