"""The pages: their links and paths exist, their lines fit, their commands have the options that they name."""

import re
import subprocess
from importlib import import_module
from pathlib import Path

import pytest

from attest_mav.cli.main import COMMANDS
from attest_mav.cli.reason_text import REASON_WORDS
from attest_mav.estimation.verdict import REASONS

REPOSITORY = Path(__file__).parents[2]
PAGES = [REPOSITORY / "README.md", REPOSITORY / "CHANGELOG.md", *sorted((REPOSITORY / "docs").rglob("*.md"))]
LONGEST_LINE = 119

LINK = re.compile(r"\]\(([^)#:]+)?(?:#([^)]+))?\)")
PLACE = re.compile(r"`((?:attest_mav|docs|tools|tests|configs|examples)/[\w./-]+)`")
COMMAND = re.compile(r"(?:^    |`)[\w./]*attest-mav (\w+)([^`\n]*)", re.MULTILINE)


def prose(page: Path) -> str:
    """The page without its blocks of output."""
    return re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)


def anchors(page: Path) -> set[str]:
    """The anchors of the headings of a page."""
    titles = re.findall(r"^#+ (.+)$", prose(page), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", title).lower().replace(" ", "-") for title in titles}


def page_name(page: Path) -> str:
    return str(page.relative_to(REPOSITORY))


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_links_lead_somewhere(page):
    for target, anchor in LINK.findall(prose(page)):
        linked = page.parent / target if target else page
        assert linked.exists(), target
        if anchor:
            assert anchor in anchors(linked), f"{target}#{anchor}"


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_paths_exist(page):
    missing = [place for place in PLACE.findall(prose(page)) if not (REPOSITORY / place).exists()]
    assert missing == []


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_lines_fit(page):
    long = [line for line in prose(page).splitlines() if len(line) > LONGEST_LINE]
    assert long == []


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_commands_have_the_options_that_are_named(page):
    for name, rest in COMMAND.findall(page.read_text(encoding="utf-8")):
        assert name in COMMANDS
        options = {option for one in import_module(f"attest_mav.cli.{name}").command.params for option in one.opts}
        assert set(re.findall(r"--[\w-]+", rest)) <= options


def test_names_of_the_glossary_are_in_the_code():
    code = "\n".join(path.read_text(encoding="utf-8") for path in (REPOSITORY / "attest_mav").rglob("*.py"))
    words = set(re.findall(r"\w+", code))
    names = re.findall(r"\(((?:`[\w.]+`(?:, )?)+)[^)]*\)", prose(REPOSITORY / "docs" / "glossary.md"))
    assert len(names) > 20
    unknown = [part for name in re.findall(r"[\w.]+", " ".join(names)) for part in name.split(".") if part not in words]
    assert unknown == []


def test_the_page_on_the_verdict_has_every_reason():
    table = re.findall(r"^\| `([\w-]+)` \|", prose(REPOSITORY / "docs" / "verdict.md"), re.MULTILINE)
    assert set(table) == set(REASONS)


def test_the_page_on_the_verdict_has_the_reasons_that_are_told_in_words():
    rows = re.findall(r"^\| `([\w-]+)` \| (\w+) \|", prose(REPOSITORY / "docs" / "verdict.md"), re.MULTILINE)
    explained = {(agreement.lower(), reason) for reason, agreement in rows if reason != "agrees"}
    assert explained == REASON_WORDS.keys()


def test_the_replay_of_the_readme_gives_the_figures_that_stand_there(command):
    readme = (REPOSITORY / "README.md").read_text(encoding="utf-8")
    call = re.search(r"attest-mav (replay [^\n]+)\n", readme)
    assert call is not None
    done = subprocess.run(
        [*command, *call[1].split()], cwd=REPOSITORY, capture_output=True, text=True, check=True, timeout=120
    )
    printed = [line.split() for line in done.stdout.splitlines()]
    rows = [line.split() for line in readme.splitlines() if re.match(r" (gradient|velocity|autopilot's)\S* .*\d", line)]
    assert len(rows) == 5
    assert [row for row in rows if row not in printed] == []
