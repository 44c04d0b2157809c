"""The page of a user's model, with its template."""

from .model_page import page_names, write_model_page

__all__ = ["page_names", "write_model_page"]
