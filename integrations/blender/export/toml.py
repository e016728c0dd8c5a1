# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes values as TOML."""

import json


def text(value):
    """A value as TOML: strings, booleans, numbers, and lists of them (by rows for matrices)."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, str):
        # JSON's escapes are those of TOML, which also wants DEL escaped
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(text, value)) + "]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {text(item)}" for key, item in value.items()) + " }"
    number = f"{float(value):.9g}"
    # "1e+20" and "5" are no floats of TOML or are whole numbers: the program takes both
    return number


def table(name, values):
    """Lines of a table, or of one element of an array of tables (`[[model]]`). Values of None are left out."""
    lines = [name] + [f"{key} = {text(value)}" for key, value in values.items() if value is not None]
    return "\n".join(lines) + "\n"
