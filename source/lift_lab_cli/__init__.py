"""The programs: train, play, evaluate, study, report, list_envs. ``scripts/`` calls them.

Importing this package and its modules is cheap: torch, the tasks and the learning libraries are imported when a program
runs, so that ``--help`` answers at once.
"""
