"""What MuJoCo may read and make of an MJCF file: no file elsewhere, no more than it can."""

from collections.abc import Iterable
from pathlib import Path

from .model_file import Folders
from .xml_tree import Element, numbers, read_xml, shown

#: Included files, at most.
MAX_INCLUDES = 256
#: Elements whose files MuJoCo reads even with all shapes removed.
READ = ("model", "hfield", "flexcomp")
#: Elements that counts may make together, and the elements that have counts: MuJoCo takes the
#: square of their number in time.
MAX_MADE = 4096
COUNTED = ("replicate", "composite", "flexcomp")
#: Of a number in <size>: keyframes, user data.
MAX_SIZE = 10_000


def include_and_check(root: Element, folders: Folders) -> None:
    """Put included files in place, and see that MuJoCo reads and makes no more than it may.

    Raises
    ------
    ModelFileError
        If a file lies outside the folders or is included twice, or too much would be made.
    """
    _include(root, folders)
    _check_files(root, folders)
    _check_counts(root)
    _check_sizes(root)


def _include(root: Element, folders: Folders) -> None:
    """Put the contents of included files where they are included."""
    seen: set[object] = set()
    for element in root.walk():
        while any(child.tag == "include" for child in element.children):
            children: list[Element] = []
            for child in element.children:
                children += _included(child, folders, seen) if child.tag == "include" else [child]
            element.children = children


def _included(element: Element, folders: Folders, seen: set[object]) -> list[Element]:
    name = element.attributes.get("file", "")
    path = _found(element, name, [name], folders)
    if path in seen or len(seen) == MAX_INCLUDES:
        element.refuse(f"<include> of {shown(name)}: a file can be included once")
    seen.add(path)
    return read_xml(path).root.children


def _found(element: Element, name: str, places: Iterable[str], folders: Folders) -> Path:
    """The file that an element names, at the first of the places where it is."""
    path = next(filter(None, map(folders.find, places)), None)
    if path is None:
        element.refuse(
            f"<{element.tag}> of {shown(name)}: there is no such file inside the model's folder or "
            "one given by '--package-path'"
        )
    return path


def _check_files(root: Element, folders: Folders) -> None:
    """See that what MuJoCo reads besides meshes lies inside the model's folders."""
    places = [""]
    for compiler in root.all("compiler"):
        places += [compiler.attributes.get(key, "") for key in ("meshdir", "assetdir")]
    for element in root.walk():
        name = element.attributes.get("file", "")
        if name and element.tag in READ:
            _found(element, name, (str(Path(place, name)) for place in places), folders)


def _check_counts(root: Element) -> None:
    """See that elements that are counted make no more than MuJoCo makes within a second."""
    made = 0
    left = [(root, 1)]
    while left:
        element, times = left.pop()
        if element.tag in COUNTED and "count" in element.attributes:
            counts = element.attributes["count"].split()
            for count in numbers(element, "count", " ".join(counts), len(counts)):
                times *= max(1, int(count))
            made += times
        elif times > 1:
            made += times
        if made > MAX_MADE:
            element.refuse(f"<{element.tag}> makes more than {MAX_MADE} elements, nested ones too")
        left += [(child, times) for child in element.children]


def _check_sizes(root: Element) -> None:
    """See that no table is asked for that fills the memory."""
    for size in root.all("size"):
        for key, text in size.attributes.items():
            # The others are of motions, which are not computed here.
            if key.startswith(("nkey", "nuser")) and numbers(size, key, text, 1)[0] > MAX_SIZE:
                size.refuse(f"'{key}' of <size> must be at most {MAX_SIZE}, got {shown(text)}")
