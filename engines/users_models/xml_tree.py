"""Reads XML as a tree whose elements know their line and place in the file; DTDs are refused.

It uses expat directly. The positions of elements are needed for messages, and to copy the text of a
link unchanged, but ElementTree and the parsers built on it or on lxml (yourdfpy, urdf_parser_py) do
not keep them. Only numbers that all engines read as the same value are accepted: PyBullet reads
`0,5` as 0, some engines take `1_0` for 10, and MuJoCo and PyBullet load a mass of `nan`.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Never
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

from ...scenarios import printable
from ...scenarios.regular_files import LARGEST_MODEL, read_regular

#: Pattern of a decimal number: no hexadecimal, no `inf`, no `nan`, no digit grouping.
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)


class ModelFileError(ValueError):
    """A model file cannot be read, or engines would read different values from it.

    The message names the file and, if possible, the line, the element and the rule that it breaks.
    """


#: Largest depth of nested elements; robots nest one body for each joint.
MAX_DEPTH = 256
#: Largest number of elements in a file, and of attributes of an element. Without these limits a
#: file of the largest permitted size could have millions of elements, each of which takes hundreds
#: of times its bytes in memory, and an engine compares the attributes of an element pairwise.
MAX_ELEMENTS, MAX_ATTRIBUTES = 1 << 18, 1 << 8
#: Largest number of characters in an attribute that makes a part of a link's name, as these names
#: are printed; and these attributes: `sep` is put between a name and a number by `replicate`.
MAX_NAME, NAMING = 1 << 10, ("name", "sep")
#: Largest number of characters of a value that messages show.
MAX_SHOWN = 60
#: Largest size of a number in a file: the product of three such numbers does not overflow.
LARGEST = 1e100
#: Pattern of an XML declaration, wherever it stands.
_DECLARATION = re.compile(rb"<\?xml\b[^>]*\?>")
#: Pattern of one tag; '>' may stand in quotes.
_TAG = re.compile(rb"""<(?:[^<>"']++|"[^"]*"|'[^']*')*+>""")
#: expat's errors about an XML declaration: engines ignore them, but other tools refuse the file.
_OF_DECLARATIONS = frozenset(
    {
        expat.errors.XML_ERROR_MISPLACED_XML_PI,
        expat.errors.XML_ERROR_XML_DECL,
        expat.errors.XML_ERROR_UNKNOWN_ENCODING,
    }
)


@dataclass(eq=False)
class Element:
    """An element of an XML file.

    Attributes
    ----------
    tag : the element's tag
    attributes : values of the attributes, by name
    file : name of the file
    line : number of the line in the file where the element begins
    span : index in the file of the element's first byte, and of the byte after its last
    children : the elements directly inside it, in the file's order
    """

    tag: str
    attributes: dict[str, str]
    file: str
    line: int
    span: tuple[int, int]
    children: list["Element"] = field(default_factory=list)

    @property
    def where(self) -> str:
        """The name of the file and the line, for example "robot.urdf:12"."""
        return f"{self.file}:{self.line}"

    def all(self, tag: str) -> list["Element"]:
        """Return the children with a given tag."""
        return [child for child in self.children if child.tag == tag]

    def only(self, tag: str) -> "Element | None":
        """Return the child with a given tag; None if there is none.

        Raises
        ------
        ModelFileError
            If there are several, of which engines do not choose the same one.
        """
        children = self.all(tag)
        if len(children) > 1:
            children[1].refuse(f"a second <{tag}> in {self}: engines do not take the same one")
        return children[0] if children else None

    def walk(self) -> Iterator["Element"]:
        """Yield the element and its descendants, without recursion.

        An element is yielded before its children, and the last child before the first. The tree may
        be changed meanwhile: the children of an element are looked up after it was yielded.
        """
        left = [self]
        while left:
            element = left.pop()
            yield element
            left += element.children

    def refuse(self, rule: str) -> Never:
        """Raise a `ModelFileError` that says which rule this element breaks."""
        raise ModelFileError(f"{self.where}: {rule}")

    def numbers(
        self, key: str, length: int | None = None, default: Sequence[float] | None = None
    ) -> tuple[float, ...]:
        """Return the numbers in an attribute.

        Parameters
        ----------
        key : name of the attribute
        length : how many numbers there must be; None allows any number of them
        default : the numbers that are returned if the attribute is missing; if None, it must exist

        Raises
        ------
        ModelFileError
            If the attribute is missing and there is no default, if its text is not `length` decimal
            numbers, or if a number is larger in size than `LARGEST`.
        """
        text = self.attributes.get(key)
        if text is None:
            if default is None:
                self.refuse(f"<{self.tag}> lacks '{key}'")
            return tuple(default)
        parts = text.split()
        for part in parts:
            if not _NUMBER.fullmatch(part):
                self.refuse(
                    f"'{key}' of <{self.tag}> must be decimal numbers, got {shown(part)}"
                    f"{_why(part)}"
                )
            if abs(float(part)) > LARGEST:
                self.refuse(
                    f"'{key}' of <{self.tag}> must be numbers up to {LARGEST:g}, got {shown(part)}"
                )
        if length not in (None, len(parts)):
            count = "one number" if length == 1 else f"{length} numbers"
            self.refuse(f"'{key}' of <{self.tag}> must be {count}, got {shown(text)}")
        return tuple(map(float, parts))

    def text(self) -> str:
        """Return the element as XML, with every element on its original line.

        So the line numbers in engines' messages are those of the user's file. Text between elements
        and comments are left out.
        """
        parts: list[str] = []
        line = 1
        left: list[Element | str] = [self]
        while left:
            one = left.pop()
            if isinstance(one, str):
                parts.append(one)
                continue
            parts.append("\n" * (one.line - line))
            line = max(line, one.line)
            inside = "".join(f" {key}={quoteattr(value)}" for key, value in one.attributes.items())
            parts.append(f"<{one.tag}{inside}>")
            left += [f"</{one.tag}>", *reversed(one.children)]
        return "".join(parts)

    def __str__(self) -> str:
        """Return the tag, with the element's name if it has one, for messages."""
        name = self.attributes.get("name")
        return f"<{self.tag}>" if name is None else f"<{self.tag} name={shown(name)}>"


def _why(part: str) -> str:
    """Return the end of a message: why engines do not all read the text `part` as one number."""
    if "$" in part:
        return ": it is xacro, expand the file first"
    if "," in part:
        return ": engines stop reading at the comma"
    return ": engines do not read it alike"


def shown(value: str) -> str:
    """Return a value from a file for messages: quoted, printable, and not too long."""
    return printable(repr(value), MAX_SHOWN)


def read_xml(path: Path) -> tuple[bytes, Element, list[str]]:
    """Read a file; return its bytes, its outermost element, and notes.

    The notes say why standard XML parsers would refuse the file although engines read it.

    Raises
    ------
    ModelFileError
        If the file cannot be read or is too large, or if `parse_xml` refuses it.
    """
    data = read_bytes(path)
    return data, *parse_xml(data, printable(str(path)))


def parse_xml(data: bytes, file: str) -> tuple[Element, list[str]]:
    """Return the outermost element of an XML file, and notes.

    The notes say why standard XML parsers would refuse the file although engines read it.

    Parameters
    ----------
    data : the bytes of the file
    file : name of the file, for messages and elements

    Raises
    ------
    ModelFileError
        If the file nests elements too deeply, has too many elements, attributes or characters in a
        name, has a DTD, is not XML in UTF-8, or is xacro.
    """
    if b"\0" in data:
        raise ModelFileError(f"{file}: must be a text in UTF-8, no engine reads UTF-16 or zeros")
    notes: list[str] = []
    try:
        root = _Builder(file, data).root
    except expat.ExpatError as error:
        if expat.errors.messages[error.code] not in _OF_DECLARATIONS:
            raise _not_xml(error, file, data) from None
        notes.append(
            f"{file}:{error.lineno}: this XML declaration breaks the standard; engines read over "
            "it, standard parsers refuse the file"
        )
        try:
            root = _Builder(file, _DECLARATION.sub(lambda m: b" " * len(m[0]), data)).root
        except expat.ExpatError as again:
            raise _not_xml(again, file, data) from None
    return root, notes + _unbound_prefixes(root)


def read_bytes(path: Path, limit: int = LARGEST_MODEL) -> bytes:
    """Return the bytes of a model file, or of one of its meshes.

    Raises
    ------
    ModelFileError
        If the file cannot be read, is no regular file, or has more than `limit` bytes.
    """
    file = printable(str(path))
    try:
        data = read_regular(path, limit)
    except OSError as error:
        raise ModelFileError(f"{file}: cannot be read: {error.strerror}") from None
    if len(data) > limit:
        raise ModelFileError(f"{file}: too large for a model, the limit is {limit} bytes")
    return data


def _not_xml(error: expat.ExpatError, file: str, data: bytes) -> ModelFileError:
    """Return the error, with line and reason, for a file that expat cannot parse.

    Parameters
    ----------
    error : expat's error
    data : the bytes of the file
    """
    rule = f"not well-formed XML: {expat.errors.messages[error.code]}"
    try:
        data.decode()
    except UnicodeDecodeError:
        rule = "must be a text in UTF-8, the only encoding that is read"
    return ModelFileError(f"{file}:{error.lineno}: {rule}")


def tag_end(data: bytes, start: int) -> int:
    """Return the index in `data` of the byte after the tag that starts at index `start`."""
    tag = _TAG.match(data, start)
    assert tag is not None, "expat has read a tag here"
    return tag.end()


class _Builder:
    """Builds a file's tree of elements from expat's events.

    Attributes
    ----------
    root : the outermost element

    Raises
    ------
    ModelFileError
        If the file nests elements too deeply, has too many elements, attributes or characters in a
        name, or has a DTD.
    expat.ExpatError
        If the file is not well-formed.
    """

    def __init__(self, file: str, data: bytes) -> None:
        self._file, self._data = file, data
        self._open = [Element("", {}, file, 0, (0, 0))]
        self._count = 0
        # A declared encoding is ignored: engines read bytes, and names are UTF-8 or ASCII.
        self._parser = expat.ParserCreate("UTF-8")
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.StartDoctypeDeclHandler = self._doctype
        self._parser.Parse(data, True)
        self.root = self._open[0].children[0]

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        """Add an element to the tree; raise `ModelFileError` if a limit is exceeded.

        expat calls this at a start tag, with the tag and its attributes.
        """
        line, start = self._parser.CurrentLineNumber, self._parser.CurrentByteIndex
        element = Element(tag, attributes, self._file, line, (start, start))
        if len(self._open) > MAX_DEPTH:
            element.refuse(f"elements are nested more than {MAX_DEPTH} deep")
        self._count += 1
        if self._count > MAX_ELEMENTS:
            element.refuse(f"more than {MAX_ELEMENTS} elements, which no model has")
        if len(attributes) > MAX_ATTRIBUTES:
            element.refuse(
                f"<{printable(tag, MAX_SHOWN)}> has more than {MAX_ATTRIBUTES} attributes"
            )
        for key in NAMING:
            if len(attributes.get(key, "")) > MAX_NAME:
                element.refuse(f"'{key}' must be at most {MAX_NAME} characters")
        self._open[-1].children.append(element)
        self._open.append(element)

    def _end(self, tag: str) -> None:  # noqa: ARG002
        """Set the span of the element that ends here; expat's argument, the tag, is ignored."""
        element = self._open.pop()
        start, own_tag = element.span[0], tag_end(self._data, element.span[0])
        # For an element without an end tag, `<a/>`, expat reports the position behind the element.
        closed = self._data[own_tag - 2 : own_tag] == b"/>"
        end = own_tag if closed else tag_end(self._data, self._parser.CurrentByteIndex)
        element.span = (start, end)

    def _doctype(self, *_: object) -> None:
        """Raise `ModelFileError`, because a DTD is refused; expat's arguments are ignored."""
        raise ModelFileError(
            f"{self._file}:{self._parser.CurrentLineNumber}: a DTD (<!DOCTYPE …>) is refused: it "
            "can make a small file huge or read other files; remove it"
        )


def _unbound_prefixes(root: Element) -> list[str]:
    """Return a note for each prefix of a tag, such as `a` in `<a:b>`, that is not declared.

    A prefix is declared by an attribute `xmlns:` of the element or of one around it.

    It raises `ModelFileError` if a prefix is that of xacro.
    """
    notes: dict[str, str] = {}
    left: list[tuple[Element, frozenset[str]]] = [(root, frozenset({"xml"}))]
    while left:
        element, bound = left.pop()
        bound |= {name[6:] for name in element.attributes if name.startswith("xmlns:")}
        prefix, colon, _ = element.tag.rpartition(":")
        if colon and prefix == "xacro":
            element.refuse(f"<{element.tag}> is xacro: expand it first, 'xacro FILE > robot.urdf'")
        if colon and prefix not in bound:
            notes.setdefault(
                prefix,
                f"{element.where}: the prefix of <{element.tag}> is not declared; engines read "
                "over it, standard parsers refuse the file",
            )
        left += [(child, bound) for child in element.children]
    return list(notes.values())
