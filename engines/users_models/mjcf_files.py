"""Limits what MuJoCo may read and make of an MJCF file: no files elsewhere, not too many elements.

MuJoCo is given the checked tree as text, with new names for the files that it may read: it opens
none of the user's files by the user's names.
"""

from collections.abc import Iterable
from pathlib import Path, PurePath

from .model_file import Folders
from .xml_tree import MAX_DEPTH, MAX_ELEMENTS, Element, read_xml, shown

#: Largest number of a model's included files, and of attached models.
MAX_INCLUDES, MAX_MODELS = 256, 64
#: Elements whose files MuJoCo reads even if all shapes are removed.
READ = ("hfield", "flexcomp")
#: Attributes with folders that the names of files are relative to.
PLACES = ("meshdir", "assetdir", "texturedir")
#: Largest number of elements that counts may make together, and the elements that have counts:
#: MuJoCo takes time by the square of their number.
MAX_MADE = 4096
COUNTED = ("replicate", "composite", "flexcomp")
#: Largest number in <size>: of keyframes, user data.
MAX_SIZE = 10_000
#: File name for an element whose file may not be read; no file has this name.
NO_FILE = "none"


class CheckedFiles:
    """Inserts included files and finds named ones, of a model and of the models it attaches.

    Attributes
    ----------
    files : paths of the files, by the names that the checked text has for them
    """

    def __init__(self, folders: Folders) -> None:
        self._folders = folders
        # Attached models by their file: the new name, and how many elements each makes; None while
        # the model is being read.
        self._models: dict[Path, tuple[str, int] | None] = {}
        self.files: dict[str, str | Path] = {}

    def check(self, root: Element) -> int:
        """Check that MuJoCo reads and makes no more than it may; return how many elements it makes.

        Raises
        ------
        ModelFileError
            If a file lies outside the folders or is included twice, or too much would be made.
        """
        self._include(root)
        attached = self._name_files(root)
        _check_sizes(root)
        return _made(root, attached)

    def _include(self, root: Element) -> None:
        """Put the contents of included files where they are included."""
        included: set[Path] = set()
        left, count = [(root, 1)], 0
        while left:
            element, depth = left.pop()
            while element.all("include"):
                element.children = [
                    inner for child in element.children for inner in self._contents(child, included)
                ]
            count += 1
            if depth > MAX_DEPTH or count > MAX_ELEMENTS:
                element.refuse(
                    f"included files make more than {MAX_ELEMENTS} elements, or nest them more "
                    f"than {MAX_DEPTH} deep"
                )
            left += [(child, depth + 1) for child in element.children]

    def _contents(self, element: Element, included: set[Path]) -> list[Element]:
        if element.tag != "include":
            return [element]
        name = element.attributes.get("file", "")
        path = self._found(element, name, [name])
        if path in included or len(included) == MAX_INCLUDES:
            element.refuse(f"<include> of {shown(name)}: a file can be included once")
        included.add(path)
        return read_xml(path)[1].children

    def _found(self, element: Element, name: str, places: Iterable[str]) -> Path:
        """Return the file that an element names, at the first of the places where it exists."""
        path = next(filter(None, map(self._folders.find, places)), None)
        if path is None:
            element.refuse(
                f"<{element.tag}> of {shown(name)}: there is no such file inside the model's "
                "folder or one given by '--package-path'"
            )
        return path

    def _name_files(self, root: Element) -> dict[str, int]:
        """Rename files that elements name; return how many elements each attached model makes."""
        folders = []
        for compiler in root.all("compiler"):
            folders += [compiler.attributes.pop(key, "") for key in PLACES]
        attached: dict[str, int] = {}
        for element in root.walk():
            name = element.attributes.get("file", "")
            if not name:
                continue
            places = [str(Path(place, name)) for place in (*folders, "")]
            if element.tag == "model":
                path = self._found(element, name, places)
                element.attributes["file"], made = self._model(element, path)
                attached[element.attributes.get("name", "")] = made
                continue
            element.attributes.setdefault("name", PurePath(name).stem)
            own, found = NO_FILE, None
            if element.tag in READ:
                found = self._found(element, name, places)
            elif element.tag == "mesh":
                found = next(filter(None, map(self._folders.find, places)), None)
            if found is not None:
                own = f"file-{len(self.files)}{found.suffix}"
                self.files[own] = found
            element.attributes["file"] = own
        return attached

    def _model(self, element: Element, path: Path) -> tuple[str, int]:
        if path not in self._models and len(self._models) < MAX_MODELS:
            name = f"model-{len(self._models)}.xml"
            self._models[path] = None
            root = read_xml(path)[1]
            if root.tag != "mujoco":
                element.refuse(f"<model> must name an MJCF file, got <{root.tag}>")
            made = self.check(root) + sum(1 for _ in root.walk())
            self._models[path] = (name, made)
            self.files[name] = root.text()
        known = self._models.get(path)
        if known is None:
            element.refuse(f"<model> attaches itself, or is one of more than {MAX_MODELS}")
        return known


def _made(root: Element, attached: dict[str, int]) -> int:
    """Return how many elements counts and attached models make; refuse more than `MAX_MADE`."""
    made = 0
    left = [(root, 1)]
    while left:
        element, times = left.pop()
        if element.tag in COUNTED and "count" in element.attributes:
            for count in element.numbers("count"):
                times *= max(1, int(count))
            made += times
        elif element.tag == "attach":
            most = max(attached.values(), default=1)
            made += times * attached.get(element.attributes.get("model", ""), most)
        elif times > 1:
            made += times
        if made > MAX_MADE:
            element.refuse(f"<{element.tag}> makes more than {MAX_MADE} elements, nested ones too")
        left += [(child, times) for child in element.children]
    return made


def _check_sizes(root: Element) -> None:
    """Check that no table is requested that would fill the memory."""
    for size in root.all("size"):
        for key, text in size.attributes.items():
            # The other sizes are of motions, which are not computed here.
            if key.startswith(("nkey", "nuser")) and size.numbers(key, 1)[0] > MAX_SIZE:
                size.refuse(f"'{key}' of <size> must be at most {MAX_SIZE}, got {shown(text)}")
