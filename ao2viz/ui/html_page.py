"""What the page says of itself, as HTML: to newcomers, and where it has lost its server."""

HINT = (
    '<div class="ao ao-hint"><h3>New here?</h3><p><b>Left:</b> an agent at work, step by step, '
    "and why it does what it does. <kbd>P</kbd> holds and goes on.</p><p><b>Middle:</b> what it "
    "has learned. Every dot is a situation that it remembers, and the pink line leads to the one "
    "that decides. Click a dot.</p><p><b>Right:</b> Start lets one learn before your eyes. "
    "<kbd>?</kbd> lists all keys.</p></div>"
)
"""For a first visit."""

OFFLINE = (
    '<div class="ao-offline" role="alert"><h3>The dashboard does not answer</h3><p>It was stopped, '
    "or cannot be reached. What you see is the last that it said. A run goes on if the dashboard "
    "does; if it was stopped, what was not saved is lost.</p><p>Start it again with "
    "<code>ao2viz</code>, or look for its address where it runs. While this page is in front it "
    "asks every second, and connects by itself.</p></div>"
)
"""Stands on every page; the style sheet shows it where a page has lost its server."""

STILL = '<span class="ao-still"></span>'
"""Lets nothing on the page glide; see static/dashboard.css."""
