# SPDX-License-Identifier: GPL-3.0-or-later
"""What an export replaced or left out."""


class Warnings:
    """Messages in the order in which they came, each once."""

    def __init__(self):
        self.messages = {}

    def add(self, message):
        """Adds a message for the user."""
        self.messages.setdefault(message)

    def add_for(self, subject, messages):
        """Adds one message for all that is to be said of one thing, such as a material."""
        said = list(dict.fromkeys(messages))
        if said:
            self.add(f"{subject}: {'; '.join(said)}")

    def __iter__(self):
        return iter(self.messages)


class Cancelled(Exception):
    """The user wants no more of it."""


class ExportError(Exception):
    """The scene cannot be exported. The text says what to do."""
