"""Edits a model file: writes the inertia of its links, and leaves every other byte as it is."""

import re
from collections.abc import Mapping

from ..checks.read_back import BodyReading
from ..models.text import decimals
from .mjcf import WAYS, inertials_of
from .model_file import ModelFile, Span
from .urdf import ZEROS, Edits
from .xml_tree import Element, parse_xml, tag_end

#: Pattern of an attribute with the blanks before it; quoted values are matched whole.
_ATTRIBUTE = re.compile(rb"""\s+([^\s=/>]+)\s*=\s*("[^"]*"|'[^']*')""")


def elements_of(model: ModelFile) -> dict[Span, Element]:
    """Return the elements of a model's own file by span; those of included files are left out."""
    root, _ = parse_xml(model.data, str(model.path))
    return {element.span: element for element in root.walk()}


def write_inertia(model: ModelFile, element: Element, body: BodyReading, remark: str = "") -> Edits:
    """Return the edits of a file that give a link the mass, com and tensor of a body.

    An edit is a span of the file, and the bytes that replace it. The tensor is written along the
    link's axes.

    Parameters
    ----------
    element : the element of the link
    body : the mass, com and tensor, in the link's frame
    remark : text of an XML comment before the link's inertial; no comment if empty
    """
    comment = f"<!-- {remark} -->".encode() if remark else b""
    inertials = inertials_of(element)
    if not inertials or inertials[0][1]:
        # An inertial inside a <frame> is replaced by one that is a child of the body itself.
        line = inertial_line(body, model.format).encode()
        gone = [(inertial.span, b"") for inertial, _ in inertials]
        return [_inside(model.data, element, comment + line), *gone]
    inertial, _ = inertials[0]
    edits = _of_urdf(model.data, inertial, body) if model.format == "urdf" else []
    if model.format == "mjcf":
        attributes: dict[str, str | None] = dict.fromkeys(("fullinertia", "diaginertia", *WAYS))
        edits = [set_attributes(model.data, inertial, attributes | _of_mjcf(body))]
    start = inertial.span[0]
    return [((start, start), comment), *edits] if comment else edits


def _of_urdf(data: bytes, inertial: Element, body: BodyReading) -> Edits:
    """Return the edits of a URDF that give an `<inertial>` the mass, com and tensor of a body.

    `data` has the bytes of the URDF.
    """
    mass, tensor = inertial.only("mass"), inertial.only("inertia")
    assert mass is not None, "the file was read"
    assert tensor is not None, "the file was read"
    entries = {f"i{axes}": decimals([value]) for axes, value in _entries(body).items()}
    edits = [set_attributes(data, tensor, entries)]
    if mass.numbers("value", 1)[0] != body.mass:
        edits.append(set_attributes(data, mass, {"value": decimals([body.mass])}))
    origin = inertial.only("origin")
    if origin is not None:
        place: dict[str, str | None] = {"rpy": None}
        if origin.numbers("xyz", 3, ZEROS) != tuple(body.com):
            place["xyz"] = decimals(body.com)
        edits.append(set_attributes(data, origin, place))
    elif body.com.any():
        edits.append(_inside(data, inertial, f'<origin xyz="{decimals(body.com)}"/>'.encode()))
    return edits


def inertial_line(body: BodyReading, form: str = "urdf") -> str:
    """Return an `<inertial>` element with a body's mass, com and tensor of inertia.

    The tensor is given along the link's axes, without a rotation of the inertial frame, because
    some engines ignore such a rotation.

    Parameters
    ----------
    body : the body, in the link's frame
    form : format of the file, "urdf" or "mjcf"
    """
    if form == "mjcf":
        inside = " ".join(f'{key}="{value}"' for key, value in _of_mjcf(body).items())
        return f"<inertial {inside}/>"
    entries = _entries(body).items()
    tensor = " ".join(f'i{axes}="{decimals([value])}"' for axes, value in entries)
    return (
        f'<inertial><origin xyz="{decimals(body.com)}"/>'
        f'<mass value="{decimals([body.mass])}"/><inertia {tensor}/></inertial>'
    )


def _of_mjcf(body: BodyReading) -> dict[str, str]:
    """Return the attributes of an MJCF's `<inertial>` with a body's mass, com and tensor.

    A tensor of zeros is written as `diaginertia`, since MuJoCo refuses it as `fullinertia`.
    """
    zero = {"diaginertia": "0 0 0"}
    tensor = {"fullinertia": decimals(_entries(body).values())} if body.inertia_com.any() else zero
    return {"pos": decimals(body.com), "mass": decimals([body.mass])} | tensor


def _entries(body: BodyReading) -> dict[str, float]:
    """Return the entries of the tensor about the com, kg m², in MJCF's order, by names as "xy"."""
    tensor = body.inertia_com
    order = ("xx", "yy", "zz", "xy", "xz", "yz")
    return {axes: float(tensor["xyz".index(axes[0]), "xyz".index(axes[1])]) for axes in order}


def set_attributes(
    data: bytes, element: Element, changes: Mapping[str, str | None]
) -> tuple[Span, bytes]:
    """Return the edit that changes an element's attributes: a span, and the bytes that replace it.

    Parameters
    ----------
    data : the bytes of the file
    changes : new values, by the names of the attributes. An attribute that the element lacks is
        added; None removes an attribute. Values are written without escaping
    """
    start, end = element.span[0], tag_end(data, element.span[0])
    left = dict(changes)

    def changed(match: re.Match[bytes]) -> bytes:
        key = match[1].decode(errors="replace")
        if key not in left:
            return match[0]
        value = left.pop(key)
        new = b"" if value is None else f'"{value}"'.encode()
        return match[0][: match.start(2) - match.start()] + new if new else b""

    tag = _ATTRIBUTE.sub(changed, data[start:end])
    new = "".join(f' {key}="{value}"' for key, value in left.items() if value is not None)
    close = b"/>" if tag.endswith(b"/>") else b">"
    return (start, end), tag.removesuffix(close).rstrip() + new.encode() + close


def _inside(data: bytes, element: Element, new: bytes) -> tuple[Span, bytes]:
    """Return the edit that inserts an XML element, `new`, as the first child of an element."""
    start, end = element.span[0], tag_end(data, element.span[0])
    tag = data[start:end]
    if tag.endswith(b"/>"):
        return (start, end), tag[:-2].rstrip() + b">" + new + f"</{element.tag}>".encode()
    return (end, end), new
