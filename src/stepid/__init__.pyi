from . import datasets as datasets
from . import errors as errors
from .ecp import read_ecp as read_ecp
from .estimate import Estimate as Estimate
from .experiment import Campaign as Campaign
from .experiment import Experiment as Experiment
from .experiment import MassOffset as MassOffset
from .files import read_campaign as read_campaign
from .files import write_campaign as write_campaign
from .step_input import StepInput as StepInput
from .table import read_table as read_table
from .transfer import transfer_function as transfer_function

__version__: str
