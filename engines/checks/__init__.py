"""Checks of what an engine holds, and of every state that it gives."""
