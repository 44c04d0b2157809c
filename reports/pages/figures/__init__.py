"""Figures, as data for plotly."""
