"""Studies: many closed loops over many settings, to find those that serve a platform and its drives best.

A *study* is a TOML file (`definition`): parameters with ranges, references for training and for judging,
objectives, constraints and a budget. It asks for *jobs* (`jobs`), one closed loop each, which are values: the
result of a job depends on its settings and its reference alone. So jobs may be done in this process, in
several, or on a cluster (`executors`, `cluster`), and a study that was interrupted goes on as if it had not
been (`search`). All results are in one store of Optuna (`store`).
"""
