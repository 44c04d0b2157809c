"""Recorded motions as files: formats, columns, units, and the motion that is read from them."""
