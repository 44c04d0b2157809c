"""Calls in processes that may crash, hang or print, here or on a cluster."""
