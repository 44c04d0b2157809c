"""Scenes that engines' derivatives are judged on: free, heavy, and on a table."""

SCENES = (
    "t-handle",
    "book-middle-axis",
    "book-in-skew-axes",
    "discus-wobble",
    "fast-top",
    "sleeping-top",
    "lopsided-body",
    "spherical-pendulum",
    "gliding-top",
    "top-with-drag-on-the-table",
)
