"""D. E. Peterson's thesis (2011) recomputed: its claims judged, and the report that shows both side by side."""
