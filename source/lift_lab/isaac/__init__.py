"""Names of Isaac Lab that lift_lab does not support, as data.

Task files of Isaac Lab import cameras, devices or generated terrains even where they do not use them. These imports
work. :mod:`table` lists each name with its module and the reason. An import hook in :mod:`finder` makes the modules.
The other files hold the fields of the configs. A config can be built and changed, but making what it describes raises
one error with the reason.

To support a name: put its class into a real file, take its name out of the table and its class out of this package.
"""
