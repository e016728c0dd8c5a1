"""Afterimage beside other renderers; `scripts/compare-peers` is the command, and says what it needs."""
