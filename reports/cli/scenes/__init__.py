"""Commands about scenes and their exact motions."""
