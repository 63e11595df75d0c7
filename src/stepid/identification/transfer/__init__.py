"""The bridge to python-control: the only room that imports it, and only when called (it takes a second to load)."""

from stepid.identification.transfer.linear import free_responses, held_response, state_space, transfer_function
from stepid.identification.transfer.nonlinear import initial_state, nonlinear_system
from stepid.identification.transfer.records import from_time_response, to_time_response
from stepid.identification.transfer.run import simulate_system

__all__ = [
    "free_responses",
    "from_time_response",
    "held_response",
    "initial_state",
    "nonlinear_system",
    "simulate_system",
    "state_space",
    "to_time_response",
    "transfer_function",
]
