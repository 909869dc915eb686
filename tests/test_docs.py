"""The pages: links lead somewhere, commands parse, Python and XML load, and numbers that are marked come out."""

import ast
import importlib
import inspect
import re
import shlex
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import typer

import nephrite
from nephrite import materials
from nephrite.cli.app import app
from nephrite.scene import build, named

ROOT = Path(__file__).resolve().parent.parent
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
SHOWN = re.compile(r"^(?P<code>.*?\S)\s+# -> (?P<value>\([^)]*\)|\S+)", re.MULTILINE)

each_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)


def text(page: Path) -> str:
    return COMMENT.sub("", page.read_text(encoding="utf-8"))


def blocks(page: Path, *languages: str) -> list[str]:
    return [code for language, code in FENCE.findall(text(page)) if language in languages]


def spans(page: Path) -> list[str]:
    return re.findall(r"`([^`\n]+)`", FENCE.sub("", text(page)))


def all_blocks(language: str) -> list:
    found = [(page, i, code) for page in PAGES for i, code in enumerate(blocks(page, language))]
    return [pytest.param(code, id=f"{page.name}-{i}") for page, i, code in found]


# --- Links ---


@each_page
def test_relative_links_lead_to_files(page: Path) -> None:
    targets = re.findall(r"\]\(([^)\s]+)\)", FENCE.sub("", text(page)))
    missing = [t for t in targets if "://" not in t and not (page.parent / t.split("#")[0]).exists()]
    assert not missing


def test_every_page_and_figure_is_linked() -> None:
    linked = " ".join(page.read_text(encoding="utf-8") for page in PAGES)
    files = [*(ROOT / "docs").glob("*.md"), *(ROOT / "docs").glob("figures/*")]
    assert not [file.name for file in files if file.name != "index.md" and file.name not in linked]


# --- Commands ---


def commands(page: Path, program: str) -> list[str]:
    lines = [line for code in blocks(page, "") for line in code.splitlines()] + spans(page)
    found = [re.split(r"\s{2,}|\s#", line.strip())[0].removeprefix(".venv/bin/") for line in lines]
    return [re.sub(r"\[.*?\]", "", line) for line in found if line.startswith(f"{program} ")]


def command_line() -> Any:
    return typer.main.get_command(app)


def parse(line: str) -> dict[str, Any]:
    """Let the command line parse `line`, and run nothing; raises what it raises."""
    group, given = command_line(), {}
    for command in group.commands.values():
        command.callback = given.update
    group.main(args=shlex.split(line)[1:], prog_name="nephrite", standalone_mode=False)
    return given


@each_page
def test_commands_parse(page: Path) -> None:
    for line in commands(page, "nephrite"):
        if "COMMAND" in line:
            continue
        given = parse(line)
        source = given.get("source")
        assert source is None or Path(source).suffix or source in named.names(), line
        names = [given.get("material"), given.get("name"), *lists(given.get("materials"))]
        for name in filter(None, names):
            if name != "NAME":
                materials.find(name)
        assert set(lists(given.get("models"))) <= {*build.MODELS, "all"}, line
        for terms in lists(given.get("terms")) if "compare" in line else []:
            build.check_terms(terms)


def lists(value: str | None) -> list[str]:
    return [part.strip() for part in re.split(r"[,|]", value or "") if part.strip()]


def test_a_wrong_command_is_noticed() -> None:
    with pytest.raises(Exception, match="--glow") as caught:
        parse("nephrite render --glow")
    assert getattr(caught.value, "exit_code", None) == 2


@each_page
def test_make_targets_exist(page: Path) -> None:
    known = set(re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    used = {line.split()[1] for line in commands(page, "make")}
    assert used <= known


@each_page
def test_long_options_exist(page: Path) -> None:
    group, known = command_line(), {"--help"}
    for command in [group, *group.commands.values()]:
        known |= {option for param in command.params for option in [*param.opts, *param.secondary_opts]}
    named_here = {option for span in spans(page) for option in re.findall(r"(?<!\S)--[a-z-]+", span)}
    assert named_here <= known


# --- Python ---


def namespace(tree: ast.Module) -> dict:
    """Do the imports of a block, and nothing else of it."""
    imports: list[ast.stmt] = [node for node in tree.body if isinstance(node, ast.Import | ast.ImportFrom)]
    known: dict = {}
    exec("import nephrite, mitsuba as mi\nfrom nephrite import materials", known)
    exec(compile(ast.Module(imports, []), "imports", "exec"), known)
    return known


def resolved(node: ast.AST, known: dict) -> object:
    """Return what a dotted name stands for, None if it isn't known before running; AttributeError if it can't be."""
    if isinstance(node, ast.Name):
        return known.get(node.id)
    if isinstance(node, ast.Attribute):
        owner = resolved(node.value, known)
        return getattr(owner, node.attr) if isinstance(owner, ModuleType | type) else None
    return None


@pytest.mark.parametrize("code", all_blocks("python"))
def test_python_uses_what_there_is(code: str) -> None:
    tree = ast.parse(code)
    known = namespace(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            resolved(node, known)
        if isinstance(node, ast.Call):
            called = resolved(node.func, known)
            if getattr(called, "__module__", "").startswith("nephrite"):
                keywords = {word.arg: None for word in node.keywords if word.arg}
                inspect.signature(called).bind(*node.args, **keywords)  # type: ignore[arg-type]


def plugin_dictionaries(tree: ast.AST) -> list[ast.Dict]:
    """Return the outermost dictionaries with a type."""
    if isinstance(tree, ast.Dict) and any(
        isinstance(k, ast.Constant) and k.value == "type" for k in tree.keys
    ):
        return [tree]
    return [found for child in ast.iter_child_nodes(tree) for found in plugin_dictionaries(child)]


@pytest.mark.parametrize("code", all_blocks("python"))
def test_dictionaries_load(code: str) -> None:
    import mitsuba as mi

    tree = ast.parse(code)
    known = namespace(tree)
    for node in plugin_dictionaries(tree):
        mi.load_dict(eval(compile(ast.Expression(node), "dictionary", "eval"), known))


@pytest.mark.parametrize("code", [p for p in all_blocks("python") if "# ->" in p.values[0]])
def test_numbers_come_out(code: str) -> None:
    known: dict = {}
    exec(code, known)
    for match in SHOWN.finditer(code):
        shown = re.findall(r"[\d.]+", match["value"])
        values = np.atleast_1d(eval(match["code"], known))
        assert len(values) == len(shown)
        for value, digits in zip(values, shown, strict=True):
            half = 0.5 * 10.0 ** -len(digits.partition(".")[2])
            assert abs(value - float(digits)) <= half * 1.0001, match[0]


@pytest.mark.parametrize("code", all_blocks("xml"))
def test_xml_loads(code: str) -> None:
    import mitsuba as mi

    mi.load_string(code)


@each_page
def test_modules_exist(page: Path) -> None:
    for span in spans(page):
        if re.fullmatch(r"nephrite(\.\w+)+", span):
            names = span.split(".")
            found = None
            for i in range(1, len(names) + 1):
                found = getattr(found, names[i - 1], None) or importlib.import_module(".".join(names[:i]))


# --- What pages and code both say ---


@pytest.mark.parametrize(
    ("heading", "module", "name"),
    [("BSDF", "translucent", "Translucent"), ("Integrator", "translucent_path", "TranslucentPath")],
)
def test_tables_list_the_parameters(heading: str, module: str, name: str) -> None:
    page = text(ROOT / "docs" / "plugins.md")
    section = re.split(rf"^## {heading} .*$", page, flags=re.MULTILINE)[1].split("\n## ")[0]
    table = section.partition("| parameter |")[2].partition("\n\n")[0]
    listed = {name for row in table.splitlines()[2:] for name in re.findall(r"`(\w+)`", row.split("|")[1])}
    manual = inspect.getdoc(getattr(importlib.import_module(f"nephrite.plugins.{module}"), name)) or ""
    documented = {
        word
        for row in re.findall(r"^\s*\* - (\w+(?:, \w+)*)$", manual, re.MULTILINE)
        for word in row.split(", ")
    }
    assert listed == documented


def test_constants_are_those_of_the_code() -> None:
    from nephrite.bssrdf import lobe, probe
    from nephrite.plugins import auto, jump, roulette

    page = text(ROOT / "docs" / "physics.md")
    for sentence in (
        f"scattering thickness below {auto.CLEAR:g} ",
        f"reduced thickness above {auto.DENSE:g} ",
        f"reduced albedo above {auto.LIGHT:g},",
        f"e^{{-n'/{lobe.LINEAR_MEMORY:g}}}$",
        f"e^{{-n'/{lobe.QUADRATIC_MEMORY:g}}}$",
        f"normal (probability {probe.AXES[0]:g}) or one of two tangents ({probe.AXES[1]:g} each)",
        f"every hit, up to {jump.MAX_HITS};",
        f"less than {100 * roulette.SHARE:g} % of the light",
        f"So beyond $n' = {roulette.ORDER:g}$ they are thinned out",
    ):
        assert sentence in page


def test_counts_and_versions() -> None:
    measured = sum(material.kind == "measured" for material in materials.all_materials())
    assert f"{measured} measured materials" in text(ROOT / "README.md")
    assert f"version: {nephrite.__version__}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\n## {nephrite.__version__} " in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_contributing_is_short() -> None:
    assert len((ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").splitlines()) < 60
