"""Fly the model of the Navajo to its published figures and print the table for the README."""

from pitotbench.evidence.reference_figures import reference_table


def main() -> None:
    print(reference_table("navajo"))


if __name__ == "__main__":
    main()
