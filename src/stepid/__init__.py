"""stepid: identify a mass-spring-damper from its step responses, then name the effect the model is missing."""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
__version__ = "0.2.0"
