"""What the README shows works as shown."""

import doctest
import re
from pathlib import Path

import automata
from bcifs.cli import app

README = (Path(__file__).parents[1] / "README.md").read_text("utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


def test_the_python_example_runs_and_prints_what_it_says(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (example,) = blocks("python")
    exec(compile(example, "README.md", "exec"), {})
    promised = re.findall(r"print\(.*\)\s+# (.+)", example)
    assert capsys.readouterr().out.splitlines() == promised
    assert (tmp_path / "sponge.3mf").stat().st_size > 1000


def test_the_interactive_examples_answer_as_shown():
    """One after the other, as a reader types them."""
    test = doctest.DocTestParser().get_doctest("\n".join(blocks("pycon")), {}, "README.md", "README.md", 0)
    assert doctest.DocTestRunner().run(test).failed == 0


def test_the_automaton_files_are_read():
    read = [automata.parse_text(text) for text in blocks("toml")]
    assert [automaton.name for automaton in read] == ["Corner cutting", "Sierpinski carpet dust"]


def test_the_command_table_lists_every_command():
    listed = re.findall(r"^\| `bcifs (\w+)", README, re.MULTILINE)
    assert sorted(listed) == sorted(command.name for command in app.registered_commands)


def test_the_picture_exists():
    for path in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", README):
        assert (Path(__file__).parents[1] / path).is_file()
