"""Reports of training runs in the form of the study that this library reproduces: its figures, its table, its claims.

``paper`` holds the study's numbers, ``curves`` reads event files, ``evaluations`` results files, ``comparison`` sets
ours beside the study's, ``figures`` draws, ``page`` writes one HTML file, ``jobs`` tells what has to be trained and
what is done.
"""
