"""Completion scripts: complete in what the parser knows, and run by the shells that are there."""

import shutil
import subprocess

import pytest

from pitotbench.cli.app import COMMANDS, SHELLS, main


def script(shell, capsys):
    assert main(["completion", shell]) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("shell", SHELLS)
def test_every_command_is_completed_with_its_flags(shell, capsys):
    text = script(shell, capsys)
    for command in COMMANDS:
        assert command.name in text
    for flag in ("mapping", "accuracy", "box-nm", "keep-logs"):
        assert f"--{flag}" in text or f"-l {flag} " in text


@pytest.mark.parametrize("shell", SHELLS)
def test_a_shell_reads_its_script(shell, capsys, tmp_path):
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    path = tmp_path / "script"
    path.write_text(script(shell, capsys), encoding="utf-8")
    done = subprocess.run([shell, "-n", str(path)], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        (["cal"], {"calibrate"}),
        (["calibrate", "--rep"], {"--report"}),
        (["plan", "--by"], {"--by-hand"}),
        (["calibrate", "fli"], set()),  # a file: left to the shell
    ],
)
def test_bash_offers_what_fits(typed, offered, capsys, tmp_path):
    if shutil.which("bash") is None:
        pytest.skip("bash is not installed")
    path = tmp_path / "script"
    words = " ".join(f'"{word}"' for word in ["pitotbench", *typed])
    asked = f'COMP_WORDS=({words}); COMP_CWORD={len(typed)}; _shtab_pitotbench; printf "%s\\n" "${{COMPREPLY[@]}}"'
    path.write_text(script("bash", capsys) + asked, encoding="utf-8")
    done = subprocess.run(["bash", str(path)], capture_output=True, text=True, check=True)
    assert set(done.stdout.split()) == offered
