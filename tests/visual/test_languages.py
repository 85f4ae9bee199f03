"""Pages in German, Chinese and Japanese: a catalogue of phrases in which no text of a page is missing."""

import ast
import dataclasses
import re
import warnings
from pathlib import Path

import pytest
from support import every_result

import pinpress as pp
from pinpress.common.results import Tabular
from pinpress.visual import languages, pages
from pinpress.visual.recording import key_frames
from pinpress.visual.reports.drawn import section
from pinpress.visual.reports.shown import as_shown

PACKAGE = Path(pp.__file__).parent
OTHERS = [code for code in languages.LANGUAGES if code != "en"]
UNITS = {"deg", "kHz", "kWh", "min", "MPa", "rad"}
OWN = {"CSV", "JavaScript", "MAC", "SHA", "Shift", "spm", "URDF", "WebGL", "pinpress", "cycle", "simulate", "points", "modes"}
OWN |= {"ANSI", "CFR", "Dpf", "IDEC", "ISO", "OSHA", "Rockwell", "SICK"}
PARTS = {"coupler", "crank", "eject", "foot", "frame", "gears", "hip", "rocker", "rod", "slide", "slide_guide"}  # links and bearings
PLACE = re.compile(r"\{\d?\}")


def english_in(text: str) -> set[str]:
    """The English words of a text in Chinese or Japanese: all Latin words but units, names and code."""
    text = re.sub(r"'[^']*'|\w+\([^)]*\)|\b[0-9a-f]{16,}|\S*[._/=]\S*|\(\w+\)\S+|link\d", "", text)
    return set(re.findall(r"[A-Za-z]{3,}", text)) - UNITS - OWN - PARTS


def is_code(text: str) -> bool:
    """Whether a text is a part as Python writes it, a sum of parameters, or the words of an error."""
    return bool(languages.OF_CODE.search(text) or re.search(r" [-+] [\d.]+ \w+ (I|mass)$", text) or text.startswith("ValueError"))


@pytest.fixture(scope="module")
def texts() -> set[str]:
    """The texts of pages with all results, of the page of a whole job, and of the template."""
    found: set[str] = set(languages.shown_by(pages._with_files("report.html")))

    def take(text: str) -> str:
        found.add(text)
        return text

    reactions = every_result.reactions()
    shown = as_shown(reactions, key_frames(reactions._press, reactions.motion))
    sections = 0
    for result in every_result.made():
        if isinstance(result, Tabular) and not isinstance(result, pp.ratings.MotionRatings):  # which is of another motion
            for part in result.described() if isinstance(result, pp.Reactions) else result.described(reactions):
                languages._mapped(section(part, shown), take)
                sections += 1
    assert sections > 50
    return found


@pytest.mark.parametrize("code", ["zh", "ja"])
def test_no_text_of_a_page_is_missing(texts: set[str], code: str) -> None:
    said = languages.language(code).said
    missing = {text: left for text in texts if not is_code(text) and (left := english_in(said(text)))}
    assert not missing


def test_no_text_of_a_whole_job_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found: set[str] = set()

    class Recorder:
        def of_page(self, data: dict[str, object], template: str) -> dict[str, object]:
            languages._mapped(data["report"], lambda text: found.add(text) or text)
            return data

    monkeypatch.setattr(languages, "language", lambda code: Recorder())
    text = (Path(__file__).parents[1] / "jobs/press_job.yaml").read_text("utf-8")
    (tmp_path / "job.yaml").write_text(text.replace("language: en", "language: de"), "utf-8")
    job = pp.job(tmp_path / "job.yaml")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        job.write_report(tmp_path / "job.html")
    monkeypatch.undo()
    said = languages.language("zh").said
    assert len(found) > 400
    assert not {text: left for text in found if not is_code(text) and (left := english_in(said(text)) - {"Doe"})}


def test_no_text_of_the_source_is_missing() -> None:
    """What rooms describe is read from their source too, as no example shows every remark."""
    said, missing = languages.language("zh").said, set()
    for file in sorted(PACKAGE.glob("*/described.py")):
        tree = ast.parse(file.read_text("utf-8"))
        pieces = {id(part) for node in ast.walk(tree) if isinstance(node, ast.JoinedStr | ast.Raise) for part in [*ast.walk(node)][1:]}
        docs = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant | ast.JoinedStr) and id(node) not in pieces | docs:
                parts = node.values if isinstance(node, ast.JoinedStr) else [node]
                text = "".join(str(part.value) if isinstance(part, ast.Constant) else "\0" for part in parts)
                # remarks behind a sentence, and a name before a colon, are said by themselves
                text = re.sub(r"^\0: ?|(?<=[.;])\0$|(?<=[a-z])\0(?=[.;]|$)", "", text.strip(" ,")).replace("\0", "7")
                if len(re.findall(r"[a-z]{3,}", text)) > 2 and not is_code(text) and english_in(said(text)):
                    missing.add(text)
    made = {"7 turns 7 at 7 r/min", "The frame from the 7, 7 over 7", "Mounts press and do not pull; 7 over 7 s.7 7"}  # of other phrases
    assert not missing - made


def test_catalogues_have_the_same_phrases_with_the_same_places() -> None:
    catalogues = {code: languages.language(code).phrases for code in OTHERS}
    first = catalogues[OTHERS[0]]
    assert len(first) > 900
    for code, phrases in catalogues.items():
        assert phrases.keys() == first.keys(), code
        lines = (PACKAGE / f"visual/templates/phrases_{code}.tsv").read_text("utf-8").splitlines()
        assert len(lines) == len(phrases)
        assert lines == sorted(lines, key=lambda line: line.split("\t")[0].lower())
        for phrase, said in phrases.items():
            assert said.strip()
            assert len(PLACE.findall(said)) == phrase.count(languages.PLACE), (code, phrase, said)


@pytest.mark.parametrize(
    ("text", "german", "chinese", "japanese"),
    [
        ("Driving torque", "Antriebsmoment", "驱动扭矩", "駆動トルク"),
        ("12.5 kN", "12,5 kN", "12.5 kN", "12.5 kN"),
        ("at 90.5 deg, 12.25 mm above bottom dead centre", "bei 90,5 deg, 12,25 mm über UT", None, None),
        ("mean of 3 turns, 1.5 kN to 2 kN", "Mittel von 3 Umdrehungen, 1,5 kN bis 2 kN", None, None),
        ("3 kN at (0, 0.5, 1) m", "3 kN at (0; 0,5; 1) m", None, None),
        ("slide position [mm]", "Stößelposition [mm]", "滑块位置 [mm]", "スライド位置 [mm]"),
        ("Force in G.3", "Kraft in G.3", "G.3 的受力", "G.3 の荷重"),
        ("pinpress 0.2.0", "pinpress 0.2.0", "pinpress 0.2.0", "pinpress 0.2.0"),
        ("Friction(coefficient=0.05)", "Friction(coefficient=0.05)", "Friction(coefficient=0.05)", "Friction(coefficient=0.05)"),
        ("my own load", "my own load", "my own load", "my own load"),
        (
            "these runs teach 3 of 9 parameters by torque, 5 with shaking force",
            None,
            "这些运行由转矩可得 9 个参数中的 3 个，加摆动力可得 5 个",
            None,
        ),
    ],
)
def test_texts_with_parts_numbers_and_names(text: str, german: str | None, chinese: str | None, japanese: str | None) -> None:
    for code, expected in zip(("de", "zh", "ja"), (german, chinese, japanese), strict=True):
        assert expected is None or languages.language(code).said(text) == expected


def test_a_header_names_its_language() -> None:
    with pytest.raises(pp.PinpressError, match="language is 'fr': write one of en, de, zh, ja"):
        pp.Header(language="fr")
    assert dataclasses.replace(pp.Header(), language="ja").language == "ja"
