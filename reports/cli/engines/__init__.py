"""Commands about engines and their versions."""
