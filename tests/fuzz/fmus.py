"""FMUs with hostile archives and hostile model descriptions."""

from __future__ import annotations

import io
import random
import re
import warnings
import zipfile
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

from hypothesis import strategies as st

from gmfbo.sources.fmu_file.models import models_folder
from tests.fuzz.mutation import ODD_WORDS, byte_changes, text_changes

_FMUS = Path(__file__).resolve().parents[1] / "fmus"
_DESCRIPTION = "modelDescription.xml"

_RICH = b"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="rich" guid="{1}" generationTool="by hand"
 description="all that a description may hold" numberOfEventIndicators="0">
<CoSimulation modelIdentifier="rich" canHandleVariableCommunicationStepSize="true"
 maxOutputDerivativeOrder="1" canGetAndSetFMUstate="true">
<SourceFiles>
<File name="a.c"/>
</SourceFiles>
</CoSimulation>
<UnitDefinitions>
<Unit name="rpm">
<BaseUnit rad="1" s="-1" factor="0.10471975511965977" offset="0"/>
<DisplayUnit name="deg" factor="57.3"/>
</Unit>
</UnitDefinitions>
<TypeDefinitions>
<SimpleType name="T">
<Real
 quantity="Torque" unit="N.m" min="-5" max="5"/>
</SimpleType>
<SimpleType name="E">
<Enumeration>
<Item name="a" value="1"/>
<Item name="b" value="2"/>
</Enumeration>
</SimpleType>
</TypeDefinitions>
<LogCategories>
<Category name="logAll"/>
</LogCategories>
<DefaultExperiment startTime="0" stopTime="1" tolerance="1e-6" stepSize="1e-3"/>
<VendorAnnotations>
<Tool name="x">
<a b="c">text</a>
</Tool>
</VendorAnnotations>
<ModelVariables>
<ScalarVariable name="u" valueReference="1"
 causality="input" variability="continuous">
<Real start="0" declaredType="T"/>
</ScalarVariable>
<ScalarVariable name="y" valueReference="2" causality="output">
<Real unit="rpm"/>
</ScalarVariable>
<ScalarVariable name="kp" valueReference="3" causality="parameter"
 variability="tunable" initial="exact"
 description="gain">
<Real start="1.5" min="0" max="9"/>
<Annotations>
<Tool name="x"/>
</Annotations>
</ScalarVariable>
<ScalarVariable name="n" valueReference="4" causality="parameter"
 variability="fixed">
<Integer start="3"/>
</ScalarVariable>
<ScalarVariable name="b" valueReference="5" causality="parameter"
 variability="fixed">
<Boolean start="true"/>
</ScalarVariable>
<ScalarVariable name="s" valueReference="6" causality="parameter"
 variability="fixed">
<String start="a"/>
</ScalarVariable>
<ScalarVariable name="e" valueReference="7">
<Enumeration declaredType="E"/>
</ScalarVariable>
<ScalarVariable name="a[1,2]" valueReference="8">
<Real derivative="2"/>
</ScalarVariable>
</ModelVariables>
<ModelStructure>
<Outputs>
<Unknown index="2" dependencies="1" dependenciesKind="dependent"/>
</Outputs>
<Derivatives>
<Unknown index="8"/>
</Derivatives>
<InitialUnknowns>
<Unknown index="2"/>
</InitialUnknowns>
</ModelStructure>
</fmiModelDescription>
"""


def _laughs() -> str:
    lines = ['<!DOCTYPE a [<!ENTITY l0 "ha">']
    lines += [f'<!ENTITY l{k} "{f"&l{k - 1};" * 10}">' for k in range(1, 12)]
    return "".join(lines) + "]>"


_DOCTYPES = (
    _laughs(),
    '<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]>',
    '<!DOCTYPE a SYSTEM "http://127.0.0.1:9/a.dtd">',
    '<!DOCTYPE a [<!ENTITY % p SYSTEM "file:///dev/zero"> %p;]>',
    '<!DOCTYPE a [<!ENTITY big "' + "b" * 100_000 + '">]>',
    "<!DOCTYPE fmiModelDescription>",
)


@cache
def archives() -> list[bytes]:
    """Whole FMUs, of a few kilobytes each."""
    chosen = [models_folder() / "linear_axis.fmu", *sorted(_FMUS.glob("*.fmu"))]
    small = [path.read_bytes() for path in chosen if path.stat().st_size < 200_000]
    return [*small, archive({_DESCRIPTION: _RICH, "binaries/linux64/rich.so": b"\x7fELF"})]


@cache
def descriptions() -> list[bytes]:
    """Model descriptions of those and of larger ones."""
    found = [_RICH]
    for path in [*sorted(_FMUS.glob("*.fmu")), *sorted(models_folder().glob("*.fmu"))]:
        with zipfile.ZipFile(path) as file:
            content = file.read(_DESCRIPTION)
        if len(content) < 30_000:
            found.append(content)
    return found


def archive(members: dict[str, bytes]) -> bytes:
    """A plain zip archive."""
    written = io.BytesIO()
    with zipfile.ZipFile(written, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content in members.items():
            file.writestr(name, content)
    return written.getvalue()


def hostile_archives() -> st.SearchStrategy[bytes]:
    """Archives with hostile members, and archives with wrong bytes."""
    made = st.builds(
        _hostile_archive,
        st.lists(st.sampled_from(sorted(_MEMBERS)), min_size=1, max_size=4),
        st.integers(0, 2**63),
    )
    return st.one_of(byte_changes(archives()), made, made.flatmap(lambda a: byte_changes([a])))


def hostile_descriptions() -> st.SearchStrategy[bytes]:
    """Whole archives whose model description is hostile."""
    xml = st.one_of(
        hostile_xml(descriptions()), text_changes(descriptions()), byte_changes(descriptions())
    )
    library = {"binaries/linux64/rich.so": b"\x7fELF"}
    return xml.map(lambda content: archive({_DESCRIPTION: content, **library}))


def hostile_xml(corpus: Sequence[bytes]) -> st.SearchStrategy[bytes]:
    """XML of a corpus with hostile tags, attributes, entities and encodings."""
    return st.builds(
        _hostile_description,
        st.sampled_from(corpus),
        st.lists(st.sampled_from(sorted(_XML)), min_size=1, max_size=4),
        st.integers(0, 2**63),
    )


def _hostile_archive(kinds: list[str], seed: int) -> bytes:
    rng, written = random.Random(seed), io.BytesIO()
    with warnings.catch_warnings(), zipfile.ZipFile(written, "w", zipfile.ZIP_DEFLATED) as file:
        warnings.simplefilter("ignore")  # a name twice is what is wanted
        if rng.random() < 0.9:
            file.writestr(_DESCRIPTION, _RICH)
        for kind in kinds:
            _MEMBERS[kind](file, rng)
        if rng.random() < 0.1:
            file.comment = rng.randbytes(rng.choice([1, 65535]))
    content = bytearray(written.getvalue())
    for _ in range(rng.choice([0, 0, 1, 3])):  # the central directory is where the sizes are
        begin = content.find(b"PK\x01\x02")
        place = rng.randrange(begin, len(content)) if begin >= 0 else 0
        content[place] = rng.choice([0, 1, 255, rng.randrange(256)])
    return bytes(content)


def _escape(file: zipfile.ZipFile, rng: random.Random) -> None:
    file.writestr(
        rng.choice(
            ["../out", "a/../../out", "/out", "C:\\out", "..\\out", "a/..", "..", ".", "//out/x",
             "a//b", "./../out", "resources/..\\..\\out", "con", "out\x00.txt", "b/../../out"]
        ),
        b"outside",
    )  # fmt: skip


def _link(file: zipfile.ZipFile, rng: random.Random) -> None:
    entry = zipfile.ZipInfo(rng.choice(["resources/link", "binaries/linux64/rich.so", "link"]))
    entry.create_system = 3
    entry.external_attr = 0o120777 << 16
    file.writestr(entry, rng.choice(["/etc/passwd", "..", "../../out", "/"]))
    if rng.random() < 0.5:
        file.writestr(entry.filename + "/out", b"through the link")


def _twice(file: zipfile.ZipFile, rng: random.Random) -> None:
    name = rng.choice([_DESCRIPTION, "binaries/linux64/rich.so", "resources/a"])
    file.writestr(name, rng.choice([_RICH, b"other", b""]))


def _bomb(file: zipfile.ZipFile, rng: random.Random) -> None:
    file.writestr("resources/zeros", bytes(rng.choice([2**16] * 20 + [2**22, 70 * 2**20])))


def _description_bomb(file: zipfile.ZipFile, rng: random.Random) -> None:
    head, tail = _RICH.split(b"<LogCategories>")
    space = rng.choice([b" ", b"<!-- -->", b"<a/>"]) * rng.choice([10**4] * 20 + [10**6])
    file.writestr(_DESCRIPTION, head + space + b"<LogCategories>" + tail)


def _many(file: zipfile.ZipFile, rng: random.Random) -> None:
    for k in range(rng.choice([10] * 5 + [500])):
        file.writestr(f"resources/{k}", b"")


def _file_and_folder(file: zipfile.ZipFile, rng: random.Random) -> None:
    names = ["resources/x", "resources/x/y", "resources/x/"]
    rng.shuffle(names)
    for name in names:
        file.writestr(name, b"x")


def _odd_name(file: zipfile.ZipFile, rng: random.Random) -> None:
    word = rng.choice(ODD_WORDS).encode("utf-8", "replace").decode()
    word = word.strip("\0") or "?"  # zipfile writes no empty name
    file.writestr(rng.choice(["{}", "resources/{}", "binaries/{}/rich.so"]).format(word), b"x")


def _packing(file: zipfile.ZipFile, rng: random.Random) -> None:
    kind = rng.choice([zipfile.ZIP_STORED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
    file.writestr("resources/packed", rng.randbytes(50) * 20, kind)


def _library(file: zipfile.ZipFile, rng: random.Random) -> None:
    folder = rng.choice(["linux64", "win64", "x86_64-linux", "darwin64", "..", "", "linux64/deep"])
    file.writestr(f"binaries/{folder}/{rng.choice(['rich', 'other', ''])}.so", b"\x7fELF")


_MEMBERS: dict[str, Callable[[zipfile.ZipFile, random.Random], None]] = {
    "bomb": _bomb, "description bomb": _description_bomb, "escape": _escape,
    "file and folder": _file_and_folder, "library": _library, "link": _link, "many": _many,
    "odd name": _odd_name, "packing": _packing, "twice": _twice,
}  # fmt: skip

_TAG = re.compile(rb"<[^<>]+>")
_VALUE = re.compile(rb'="[^"]*"')


def _hostile_description(content: bytes, kinds: list[str], seed: int) -> bytes:
    rng = random.Random(seed)
    for kind in kinds:
        content = _XML[kind](content, rng)
    return content


def _doctype(content: bytes, rng: random.Random) -> bytes:
    head, end, tail = content.partition(b"?>")
    use = rng.choice([b"", b"&l11;", b"&x;", b"&big;" * 100])
    tail = tail.replace(b"<ModelVariables>", b"<ModelVariables>" + use, 1)
    return head + end + rng.choice(_DOCTYPES).encode() + tail


def _value(content: bytes, rng: random.Random) -> bytes:
    found = list(_VALUE.finditer(content))
    if not found:
        return content
    at = rng.choice(found)
    words = [
        *ODD_WORDS,
        "-1",
        "4294967296",
        "1e400",
        "z" * 10**6,
        "&l9;",
        "&#x10FFFF;",
        "2.1",
        "3.0",
    ]
    word = rng.choice(words).encode("utf-8", "replace")
    return content[: at.start() + 2] + word.replace(b'"', b"&quot;") + content[at.end() - 1 :]


def _attribute(content: bytes, rng: random.Random) -> bytes:
    found = list(re.finditer(rb'\s\w+="[^"]*"', content))
    if not found:
        return content
    at = rng.choice(found)
    return content[: at.start()] + at[0] * rng.choice([0, 0, 2]) + content[at.end() :]


def _tag(content: bytes, rng: random.Random) -> bytes:
    found = list(_TAG.finditer(content))
    if not found:
        return content
    at, other = rng.choice(found), rng.choice(found)
    put = rng.choice([b"", at[0] * 2, other[0], at[0] * 500, b"<x/>", b"<![CDATA[x]]>", b"<?pi?>"])
    return content[: at.start()] + put + content[at.end() :]


def _deep(content: bytes, rng: random.Random) -> bytes:
    depth = rng.choice([100, 300, 300, 100_000])
    nest = b"<a>" * depth + b"</a>" * rng.choice([depth, 0])
    return content.replace(b"<ModelVariables>", nest + b"<ModelVariables>", 1)


def _variables(content: bytes, rng: random.Random) -> bytes:
    lines = b"".join(
        b'<ScalarVariable name="v%d" valueReference="%d"><Real/></ScalarVariable>' % (k, k)
        for k in range(rng.choice([10] * 5 + [3000]))
    )
    return content.replace(b"</ModelVariables>", lines + b"</ModelVariables>", 1)


def _encoding(content: bytes, rng: random.Random) -> bytes:
    name = rng.choice([b"UTF-16", b"latin-1", b"UTF-7", b"EBCDIC-CP-US", b"x" * 1000, b"ascii"])
    changed = content.replace(b"UTF-8", name, 1)
    try:
        return changed.decode().encode(rng.choice(["utf-8", "utf-16", "utf-32"]))
    except UnicodeDecodeError:
        return changed


_XML: dict[str, Callable[[bytes, random.Random], bytes]] = {
    "attribute": _attribute, "deep": _deep, "doctype": _doctype, "encoding": _encoding,
    "tag": _tag, "value": _value, "variables": _variables,
}  # fmt: skip
