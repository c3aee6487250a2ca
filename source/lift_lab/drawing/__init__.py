"""Frames and videos with MuJoCo's own renderer, drawn in this process or in one of their own.

This package uses neither environments nor torch. It draws from arrays, so the process that draws a training run's
videos starts fast and stays small.
"""
