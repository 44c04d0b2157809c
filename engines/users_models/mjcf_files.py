"""Limits which files MuJoCo reads for an MJCF file, and how many elements it generates from it.

MuJoCo is given the checked tree as text, with new names for the files that it may read: it opens
none of the user's files by the user's names.
"""

from collections.abc import Iterable
from pathlib import Path, PurePath

from .model_file import Folders
from .xml_tree import MAX_DEPTH, MAX_ELEMENTS, Element, read_xml, shown

#: Largest number of files that a model includes, and of models that are attached.
MAX_INCLUDES, MAX_MODELS = 256, 64
#: Tags of elements whose files MuJoCo reads even if all shapes are removed.
READ = ("hfield", "flexcomp")
#: Attributes of <compiler> that name the folders to which file names are relative.
PLACES = ("meshdir", "assetdir", "texturedir")
#: Largest number of elements that MuJoCo may generate from a model, in time that grows as the
#: square of this number; and the tags of elements that are generated as often as their count says.
MAX_MADE = 4096
COUNTED = ("replicate", "composite", "flexcomp")
#: Largest number of keyframes, or of user data, that <size> may state.
MAX_SIZE = 10_000
#: File name that is written for a file that may not be read; no file has this name.
NO_FILE = "none"


class CheckedFiles:
    """Checks a model and the models that it attaches: inserts included files, renames other files.

    Parameters
    ----------
    folders : the folders in which the files that a model names must be

    Attributes
    ----------
    files : what the new file names in the checked text stand for, by new name: the path of a file,
        or the text of an attached model
    """

    def __init__(self, folders: Folders) -> None:
        self._folders = folders
        # By the file of each attached model, the new name of the file and the number of elements
        # that the model expands to; None while the model is being read.
        self._models: dict[Path, tuple[str, int] | None] = {}
        self.files: dict[str, str | Path] = {}

    def check(self, root: Element) -> int:
        """Check a model, insert included files, and write new names for the files that it names.

        Parameters
        ----------
        root : the model's outermost element, which is changed in place

        Returns
        -------
        The number of elements that MuJoCo generates from the model, besides those in the file

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
        """Replace each `include` in a model by the contents of the file that it names.

        It raises `ModelFileError` if a file cannot be included, or if there are then too many
        elements, or too deeply nested ones.
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
        """Return the elements that replace an element.

        For an `include` these are the elements of the file that it names; any other element stays
        as it is.

        Parameters
        ----------
        included : the files that were included before, to which the named file is added

        Raises
        ------
        ModelFileError
            If the file is not found, was included before, or exceeds `MAX_INCLUDES`.
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
        """Return the path of the file that an element names: the first of `places` that exists.

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
        """Replace the file names in a model's elements by new ones.

        Files that MuJoCo may read are added to `files`; no file on disk is renamed.

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
        """Check an attached model; return its new file name and how many elements it expands to.

        `path` is the file of the model, and `element` the one that names this file.
        """
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
    """Return the number of elements that MuJoCo generates from a model.

    It raises `ModelFileError` if these are more than `MAX_MADE`.

    Parameters
    ----------
    root : the model, in which elements with a count, and `attach`, generate others
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
            # The other sizes matter only for motions, and none are computed here.
            if key.startswith(("nkey", "nuser")) and size.numbers(key, 1)[0] > MAX_SIZE:
                size.refuse(f"'{key}' of <size> must be at most {MAX_SIZE}, got {shown(text)}")
