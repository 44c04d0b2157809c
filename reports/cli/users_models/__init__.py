"""Commands about users' own models."""
