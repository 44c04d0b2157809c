"""Limits which files MuJoCo reads for an MJCF file, and how many elements it generates from it.

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
#: Largest number of elements that MuJoCo may generate for all elements with a count, and the tags
#: of elements with a count. MuJoCo's time grows as the square of the number.
MAX_MADE = 4096
COUNTED = ("replicate", "composite", "flexcomp")
#: Largest number in <size>: of keyframes, user data.
MAX_SIZE = 10_000
#: File name for an element whose file may not be read; no file has this name.
NO_FILE = "none"


class CheckedFiles:
    """Checks a model and the models that it attaches: inserts included files, finds named files.

    Attributes
    ----------
    files : paths of the files, or texts of attached models, by the names that replace the files'
        own names in the checked text
    """

    def __init__(self, folders: Folders) -> None:
        self._folders = folders
        # Attached models by their file: the new name of the file, and the number of elements that
        # the model expands to; None while the model is being read.
        self._models: dict[Path, tuple[str, int] | None] = {}
        self.files: dict[str, str | Path] = {}

    def check(self, root: Element) -> int:
        """Check a model, replace the names of the files that it names; return a number of elements.

        These are the elements that MuJoCo generates from the model, besides those in the file.

        Raises
        ------
        ModelFileError
            If a file lies outside the folders or is included twice, or if MuJoCo would generate too
            many elements.
        """
        self._include(root)
        attached = self._name_files(root)
        _check_sizes(root)
        return _made(root, attached)

    def _include(self, root: Element) -> None:
        """Replace each `include` inside an element by the contents of the file that it names.

        It raises `ModelFileError` if a file cannot be included, or the elements are too many or too
        deep.
        """
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
        """Return the elements of the file that an `include` names; any other element, alone.

        Parameters
        ----------
        included : the files that were included before, to which the named file is added

        Raises
        ------
        ModelFileError
            If the file is not found, was included before, or is one too many.
        """
        if element.tag != "include":
            return [element]
        name = element.attributes.get("file", "")
        path = self._found(element, name, [name])
        if path in included or len(included) == MAX_INCLUDES:
            element.refuse(f"<include> of {shown(name)}: a file can be included once")
        included.add(path)
        return read_xml(path)[1].children

    def _found(self, element: Element, name: str, places: Iterable[str]) -> Path:
        """Return the file that an element names: the first of several paths that exists.

        Parameters
        ----------
        element : the element, which is refused if no path exists
        name : the file's name in the element, for the message
        places : paths that the name may mean
        """
        path = next(filter(None, map(self._folders.find, places)), None)
        if path is None:
            element.refuse(
                f"<{element.tag}> of {shown(name)}: there is no such file inside the model's "
                "folder or one given by '--package-path'"
            )
        return path

    def _name_files(self, root: Element) -> dict[str, int]:
        """Replace the file names in a model's elements; no file on disk is renamed.

        Returns
        -------
        The number of elements that each attached model expands to, by the model's name
        """
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
        """Check an attached model; return its new name and the number of its elements."""
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
    """Return the number of elements that MuJoCo generates; refuse more than `MAX_MADE`.

    Parameters
    ----------
    root : the model, whose elements with a count or `attach` generate others
    attached : the number of elements that each attached model expands to, by name
    """
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
    """Raise `ModelFileError` if `<size>` states too large a number of keyframes or user data."""
    for size in root.all("size"):
        for key, text in size.attributes.items():
            # The other sizes are of motions, which are not computed here.
            if key.startswith(("nkey", "nuser")) and size.numbers(key, 1)[0] > MAX_SIZE:
                size.refuse(f"'{key}' of <size> must be at most {MAX_SIZE}, got {shown(text)}")
