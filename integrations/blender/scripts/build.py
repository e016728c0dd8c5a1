# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the extension's .zip, and validates it: what `make blender` runs.

    python3 integrations/blender/scripts/build.py TARGET [WHEEL]

WHEEL is carried in the .zip, so that Blender installs the renderer with the extension. Blender's own tool builds and validates: that of
`blender`, or of the Python that BPY_PYTHON names (python3), where bpy is installed.
"""

import os
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
LEFT_OUT = shutil.ignore_patterns("__pycache__", "tests", "scripts", "*.zip")


def tool():
    """The command of Blender's tool for extensions; None where there is none."""
    blender = shutil.which("blender")
    if blender:
        return [blender, "--command", "extension"]
    python = os.environ.get("BPY_PYTHON") or "python3"
    code = "import importlib.util as u; print(u.find_spec('bpy').submodule_search_locations[0])"
    found = subprocess.run([python, "-c", code], capture_output=True, text=True, check=False)
    for root, _, names in os.walk(found.stdout.strip()) if found.returncode == 0 else ():
        if "blender_ext.py" in names:
            return [python, os.path.join(root, "blender_ext.py")]
    return None


def stage(target, wheel):
    """Copies the extension without tests, with the wheel and the licence, and returns the folder."""
    folder = os.path.join(target, "afterimage_render")
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(HERE, folder, ignore=LEFT_OUT)
    if wheel:
        os.makedirs(os.path.join(folder, "wheels"))
        shutil.copy(wheel, os.path.join(folder, "wheels"))
        manifest = os.path.join(folder, "blender_manifest.toml")
        with open(manifest, encoding="utf-8") as file:
            text = file.read()
        # keys of the file itself must stand before its first table
        line = f'wheels = ["./wheels/{os.path.basename(wheel)}"]\n\n[permissions]'
        with open(manifest, "w", encoding="utf-8") as file:
            file.write(text.replace("[permissions]", line, 1))
    return folder


def main():
    target, wheel = os.path.abspath(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else None
    command = tool()
    if command is None:
        sys.exit("make blender needs `blender`, or a Python with bpy: BPY_PYTHON=/path/to/python make blender")
    os.makedirs(target, exist_ok=True)
    folder = stage(target, wheel)
    subprocess.run([*command, "build", "--source-dir", folder, "--output-dir", target], check=True)
    made = max((os.path.join(target, name) for name in os.listdir(target) if name.endswith(".zip")), key=os.path.getmtime)
    subprocess.run([*command, "validate", made], check=True)
    print(made)
    if not wheel:
        print("without the renderer, which is in the wheel that `make wheel` makes: this .zip exports shots alone")


main()
