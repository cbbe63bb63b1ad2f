"""Results of the library: immutable records in SI units, made from results of the solvers, and conversion to JSON.

To add a number to the results, add a field ``quantity_field(key, definition, heading=...)`` to the record of its group:
`BallResult` (every ball), `BallLoadSummary` and `SetResult` (a nut or bearing) in `models.set_results`, `BallContact`
(contact of the highest pressure) in `lowfi.rating.contacts`. The number is then in the JSON and in the manual, and with a
heading also in the table of results. CONTRIBUTING names the other places.
"""
