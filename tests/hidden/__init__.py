"""The hidden plant: data with a known missing effect, from code that shares nothing with `stepid`'s own simulator."""

from .fast import fast as fast
from .plant import DRAWN as DRAWN
from .plant import EVERY as EVERY
from .plant import NAMES as NAMES
from .plant import NEW as NEW
from .plant import Run as Run
from .plant import runs_like as runs_like
from .reference import reference as reference
