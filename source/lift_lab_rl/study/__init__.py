"""Reports of training runs beside the results of a paper: its figures, its table, its claims.

``paper`` holds the paper's numbers, which a task registers. ``curves`` reads event files, ``evaluations`` reads results
files. ``comparison`` makes tables of our numbers and the paper's. ``figures`` draws, and ``page`` writes one HTML file.
``jobs`` lists the trainings that are to do and that are done.
"""
