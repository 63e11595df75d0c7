from . import datasets as datasets
from . import errors as errors
from . import plot as plot
from .ecp import read_ecp as read_ecp
from .estimate import Estimate as Estimate
from .experiment import Campaign as Campaign
from .experiment import Experiment as Experiment
from .experiment import MassOffset as MassOffset
from .files import read_campaign as read_campaign
from .files import write_campaign as write_campaign
from .paper import rebuild_paper as rebuild_paper
from .parameters import IdentifiedParameters as IdentifiedParameters
from .parameters import StackedSystem as StackedSystem
from .parameters import Verification as Verification
from .response import Characteristics as Characteristics
from .response import CharacteristicsUncertainty as CharacteristicsUncertainty
from .solution import solve as solve
from .solvers import OrdinaryLeastSquares as OrdinaryLeastSquares
from .solvers import WeightedLeastSquares as WeightedLeastSquares
from .stacked import assemble as assemble
from .step_input import StepInput as StepInput
from .table import read_table as read_table
from .transfer import transfer_function as transfer_function
from .verify import verify as verify

__version__: str
