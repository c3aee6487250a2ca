"""The programs of the console command ``lift-lab``. The files in ``scripts/`` run the same programs.

Importing this package and its modules is fast, so ``--help`` answers at once. Torch, the tasks and the learning
libraries are imported when a program runs.
"""
