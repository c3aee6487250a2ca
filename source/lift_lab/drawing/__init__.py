"""Frames and videos with MuJoCo's own renderer, drawn in this process or in one of their own.

Nothing here knows of environments, and nothing needs torch: what is drawn arrives as arrays, so that the process that
draws a training run's videos starts fast and stays small.
"""
