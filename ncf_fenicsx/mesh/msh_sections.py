"""Sections of a gmsh file, and the numbers in them one after the other, be they text or binary."""

from __future__ import annotations

import re
import warnings

import numpy as np
from numpy.typing import DTypeLike, NDArray

from ncf_fenicsx.mesh.mesh_file import Floats, Integers, fail

READ = "expected a gmsh file of format 4.1 or 2.2"
NEEDED = ("MeshFormat", "PhysicalNames", "Entities", "Nodes", "Elements")
HEAD = re.compile(rb"\s*\$(\w+)[ \t\r]*\n")
VERSIONS = {"2": "2.2", "2.0": "2.2", "2.1": "2.2", "2.2": "2.2", "4": "4.1", "4.1": "4.1"}
"""Formats that are read, each with the one whose layout it has."""
LARGEST = 2**53
"""Whole numbers below are exact in the floats that text is read into."""


def sections(data: bytes) -> dict[str, bytes]:
    """Bodies of the sections that are needed, by name; others are passed over."""
    if not data.strip():
        fail(f"is empty; {READ}")
    if data.lstrip().startswith(b"$NOD"):
        fail("format 1: save as 4.1 or 2.2")
    found: dict[str, bytes] = {}
    at = 0
    while match := HEAD.match(data, at):
        name = match[1].decode()
        if not found and name not in ("MeshFormat", "Comments"):
            break
        end = data.find(f"$End{name}".encode(), match.end())
        if end < 0:
            fail(f"section ${name} has no end; expected $End{name}: the file is cut off")
        if name in found:
            fail(f"has two sections ${name}; expected one")
        if name in NEEDED:
            found[name] = data[match.end() : end]
        at = end + len(f"$End{name}")
    if "MeshFormat" not in found:
        fail(f"does not begin with $MeshFormat; {READ}")
    if data[at:].strip():
        fail(f"{data[at:].strip()[:20]!r} stands after section ${list(found)[-1]}; expected the next section")
    return found


def layout(body: bytes) -> tuple[str, bool, int]:
    """Format 2.2 or 4.1, whether numbers are binary, and the bytes of a size, from the section $MeshFormat."""
    line, _, rest = body.partition(b"\n")
    words = line.decode("latin-1").split()
    if len(words) != 3 or words[1] not in ("0", "1") or words[2] not in ("4", "8"):
        fail(f"$MeshFormat says {' '.join(words)[:40]!r}; expected three numbers such as '4.1 0 8'")
    if words[0] not in VERSIONS:
        fail(f"format {words[0][:20]}: save as 4.1 or 2.2")
    if words[1] == "1" and rest[:4] != b"\x01\x00\x00\x00":
        fail("its binary numbers have the order of bytes of another machine; expected text, or the least byte first")
    return VERSIONS[words[0]], words[1] == "1", int(words[2])


class Numbers:
    """Numbers of a section, taken one after the other.

    Args:
        name: of the section.
        body: its contents.
        binary: whether they are binary; else text.
        size: bytes of a size where they are binary.
    """

    def __init__(self, name: str, body: bytes, binary: bool, size: int) -> None:
        self.name, self.binary, self._body, self._at = name, binary, body, 0
        self._size = np.dtype(f"<u{size}")
        self._text: Floats | None = None

    def first_line(self) -> int:
        """The number in the first line, which is text even in a binary file of format 2.2."""
        line, _, self._body = self._body.partition(b"\n")
        if not re.fullmatch(rb"\d{1,15}", line.strip()):
            fail(f"section ${self.name} begins with {line.strip()[:20]!r}; expected a number of entries")
        return int(line)

    def whole(self, count: int) -> Integers:
        """Whole numbers, 4 bytes each in a binary file."""
        return self.exact(self.take(count, "<i4"))

    def sizes(self, count: int) -> Integers:
        """Whole numbers, as many bytes each as a size in a binary file."""
        return self.exact(self.take(count, self._size))

    def size(self) -> int:
        """Number of entries that follow."""
        value = int(self.sizes(1)[0])
        return value if value >= 0 else fail(f"section ${self.name} announces {value} entries; expected none or more")

    def exact(self, values: NDArray) -> Integers:
        """Values as whole numbers."""
        floats = values.astype(float)
        wrong = np.flatnonzero((floats != np.floor(floats)) | (np.abs(floats) >= LARGEST))
        if len(wrong):
            fail(f"section ${self.name} holds {values[wrong[0]]:g}; expected a whole number")
        return values.astype(np.int64)

    def take(self, count: int, kind: DTypeLike) -> NDArray:
        """The next numbers, of a kind where they are binary, else as floats."""
        source: NDArray = self._values if not self.binary else np.frombuffer(self._body, np.uint8)
        width = np.dtype(kind).itemsize if self.binary else 1
        if count > (len(source) - self._at) // width:
            fail(f"section ${self.name} ends early; expected as many numbers as it announces: the file is cut off")
        self._at += count * width
        return source[self._at - count * width : self._at].view(kind if self.binary else float)

    def rest(self) -> Integers:
        """All whole numbers of a text that are left."""
        return self.exact(self.take(len(self._values) - self._at, float))

    def end(self) -> None:
        """Refuse what is left: it was not announced."""
        left = len(self._body[self._at :].strip()) if self.binary else len(self._values) - self._at
        if left:
            fail(f"section ${self.name} holds more than it announces; expected its end")

    @property
    def _values(self) -> Floats:
        if self._text is None:
            self._text = self._read_text()
        return self._text

    def _read_text(self) -> Floats:
        if not self._body.strip():
            return np.zeros(0)
        with warnings.catch_warnings():
            warnings.simplefilter("error", DeprecationWarning)
            try:
                return np.fromstring(self._body, sep=" ")
            except (DeprecationWarning, ValueError):
                return fail(f"section ${self.name} holds what is no number; expected numbers and nothing else")
