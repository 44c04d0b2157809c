"""Users' models inspected: what engines hold of them beside their files, in words and pages."""
