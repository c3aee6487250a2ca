"""Reports of training runs beside the results of a paper: its figures, its table, its claims.

``paper`` is the form of the paper's numbers, which a task brings; ``curves`` reads event files, ``evaluations`` results
files; ``comparison`` makes tables of ours and the paper's; ``figures`` draws; ``page`` writes one HTML file; ``jobs``
tells what has to be trained and what is done.
"""
