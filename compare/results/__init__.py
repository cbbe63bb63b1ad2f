"""Results of the library: immutable records in SI units, made from those of the solvers, and their conversion to JSON.

To add a number to the results, add a field ``quantity(key, definition, heading=...)`` to the record of its group: `BallRow`
(every ball), `BallLoadSummary` and `Axial` in `scene_json`, `Contact` (worst contact) in `lowfi.rating.contacts`. JSON and
manual follow, with a heading also the table of answers. CONTRIBUTING names the other places.
"""
