"""`pitotbench completion`: the script with which a shell completes commands and flags."""

import argparse
import sys
from collections.abc import Iterable

from pitotbench.cli.exit_codes import DONE

SHELLS = ("bash", "zsh", "fish")

_BASH = """\
# pitotbench: completion for bash. In ~/.bashrc:  eval "$(pitotbench completion bash)"
_pitotbench() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} known=""
  COMPREPLY=()
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W "{commands} {flags}" -- "$word"))
    return
  fi
  case ${{COMP_WORDS[1]}} in
{cases}
  esac
  # Anything else is a file: the shell's own completion (-o default).
  case $word in -*) COMPREPLY=($(compgen -W "$known" -- "$word")) ;; esac
}}
complete -o default -F _pitotbench pitotbench
"""
_ZSH = """\
#compdef pitotbench
# pitotbench: completion for zsh. In ~/.zshrc, after compinit:  eval "$(pitotbench completion zsh)"
_pitotbench() {{
  local -a known
  if (( CURRENT == 2 )); then
    known=({described})
    _describe command known
    return
  fi
  case ${{words[2]}} in
{cases}
  esac
  if [[ $PREFIX == -* ]]; then compadd -- $known; else _files; fi
}}
compdef _pitotbench pitotbench
"""
_FISH = """\
# pitotbench: completion for fish. Once:  pitotbench completion fish > ~/.config/fish/completions/pitotbench.fish
{commands}
{flags}
"""


def add(parser: argparse.ArgumentParser) -> None:
    """Add the flags of `pitotbench completion`."""
    parser.add_argument("shell", choices=SHELLS, help="the shell; the script is printed")


def run(options: argparse.Namespace) -> int:
    """Print the completion script of a shell; return exit code 0."""
    sys.stdout.write({"bash": _bash, "zsh": _zsh, "fish": _fish}[options.shell]())
    return DONE


def _flags() -> dict[str, dict[str, str]]:
    """Return for each command its long flags, each with the first line of its help."""
    from importlib import import_module

    from pitotbench.cli.commands import COMMANDS
    from pitotbench.cli.parsers import OneLineParser

    found = {}
    for command in COMMANDS:
        parser = OneLineParser(prog=command.name)
        import_module(command.module).add(parser)
        # argparse has no public list of its flags; this attribute is as old as argparse.
        actions = parser._option_string_actions.items()
        found[command.name] = {flag: action.help or "" for flag, action in actions if flag.startswith("--")}
    return found


def _bash() -> str:
    flags = _flags()
    cases = "\n".join(f'    {name}) known="{_joined(own)}" ;;' for name, own in flags.items())
    return _BASH.format(commands=_joined(flags), flags="--help --version", cases=cases)


def _zsh() -> str:
    from pitotbench.cli.commands import COMMANDS

    described = " ".join(_quoted(f"{c.name}:{c.summary.replace(':', ',')}") for c in COMMANDS)
    cases = "\n".join(f"    {name}) known=({_joined(own)}) ;;" for name, own in _flags().items())
    return _ZSH.format(described=described, cases=cases)


def _fish() -> str:
    from pitotbench.cli.commands import COMMANDS

    first = [
        f"complete -c pitotbench -n __fish_use_subcommand -a {c.name} -d {_quoted(c.summary)}" for c in COMMANDS
    ]
    rest = [
        f"complete -c pitotbench -n '__fish_seen_subcommand_from {name}' -l {flag[2:]} -d {_quoted(_plain(words))}"
        for name, own in _flags().items()
        for flag, words in own.items()
    ]
    return _FISH.format(commands="\n".join(first), flags="\n".join(rest))


def _plain(words: str) -> str:
    """Return a help text without argparse's placeholders."""
    return words.partition(" (default: %")[0]


def _joined(words: Iterable[str]) -> str:
    return " ".join(words)


def _quoted(text: str) -> str:
    """Return a text in single quotes, as all three shells read it."""
    return "'" + text.replace("'", "’") + "'"
