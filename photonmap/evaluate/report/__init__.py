"""What the bench writes: tables as text, CSV and LaTeX, and the page."""
