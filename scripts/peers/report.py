"""Words to whoever waits, and Markdown."""


def say(text):
    print(f"compare-peers: {text}", flush=True)


def markdown(lines):
    """A table of cells; the second line says how columns are aligned."""
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def rounded(value, digits):
    """Without the sign of what rounds to zero."""
    return round(value, digits) + 0.0
