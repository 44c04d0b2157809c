"""Prints the lines of code of each folder: without docstrings, comments and blank lines."""

import ast
import io
import tokenize
from pathlib import Path

ROOT = Path(__file__).parents[1]
FOLDERS = ("reference", "engines", "scenarios", "reports", "tests")
DOCUMENTED = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
#: Tokens that are no code.
SPACE = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT}
SPACE |= {tokenize.ENDMARKER}


def lines_of_code(source: str) -> int:
    """Return how many lines of a Python source have code on them."""
    code = set()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type not in SPACE:
            code |= {*range(token.start[0], token.end[0] + 1)}
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, DOCUMENTED) and ast.get_docstring(node) is not None:
            code -= {*range(node.body[0].lineno, node.body[0].end_lineno + 1)}
    return len(code)


if __name__ == "__main__":
    for folder in FOLDERS:
        files = (ROOT / folder).rglob("*.py")
        print(f"{sum(lines_of_code(file.read_text('utf-8')) for file in files):6} {folder}")
