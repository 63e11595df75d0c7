from . import datasets as datasets
from . import errors as errors
from .estimate import Estimate as Estimate
from .experiment import Campaign as Campaign
from .experiment import Experiment as Experiment
from .experiment import MassOffset as MassOffset
from .transfer import transfer_function as transfer_function

__version__: str
