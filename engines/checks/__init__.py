"""Checks of the model that an engine has loaded, and of every state that it returns."""
