"""Parameters of the linear plant by the peak method: characteristics, stacked system, solvers, trends."""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach(__name__, ["characteristics"])
