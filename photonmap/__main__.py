"""`python -m photonmap`."""

from photonmap.commands.main import run_program

run_program()
