"""The Commander: build, run, watch, tune and stop a run in a browser, without the page being able to hurt it.

Three processes: the *server* (`app`, `routes`, `stream`, `security`), the *worker* that simulates (`runner`),
and the keeper that starts both and starts a dead one anew (`keeper`). They share memory: rows of signals
(`rows`), what the worker says of itself, and the orders that the server gives (`orders`). The server reads
the first two and writes only the last, so a page that is slow, hung or hostile cannot delay a run.
"""
