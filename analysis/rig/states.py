"""The rig's state machine as data: what may happen in which state, and what follows.

States and tasks are those of the thesis's Fig. A.8b: initialisation, operation with the tasks configuration, homing,
jog and control, and stop. Of the tasks only one is open at a time; a task that moves the machine has a state of its
own for that, in which the motors have power. Whatever is not in ``TRANSITIONS`` is refused.
"""

from collections.abc import Mapping
from enum import StrEnum
from types import MappingProxyType


class State(StrEnum):
    """Where the rig is."""

    INITIALISE = "initialise"  # start-up: encoders count from an unknown position
    OPERATE = "operate"  # no task is open
    CONFIGURE = "configure"
    HOME = "home"
    HOMING = "homing"  # moves
    JOG = "jog"
    JOGGING = "jogging"  # moves
    CONTROL = "control"
    LOADED = "loaded"  # the control task has a trajectory
    EXECUTING = "executing"  # moves
    STOP = "stop"  # brought to rest, brakes on, until it is reset
    OFF = "off"  # the end


class Event(StrEnum):
    """What happens: requests of the user first, then what the machine reports."""

    CONFIGURE = "configure"  # open a task
    HOME = "home"
    JOG = "jog"
    CONTROL = "control"
    CLOSE = "close"  # the open task
    SET = "set"  # a configuration
    LOAD = "load"  # a trajectory
    START = "start"  # to move
    HALT = "halt"  # the motion; done once it has come to rest
    QUICK_STOP = "quick_stop"
    RESET = "reset"
    SHUT_DOWN = "shut_down"
    INITIALISED = "initialised"
    DONE = "done"  # the motion is complete
    LIMIT = "limit"  # a limit switch was reached
    FAULT = "fault"  # following error, divergence, lost pace


REQUESTS = tuple(Event)[: tuple(Event).index(Event.INITIALISED)]
MOVING = frozenset({State.HOMING, State.JOGGING, State.EXECUTING})
# Tasks that make sense only once the machine knows where it is.
NEEDS_HOME = frozenset({(State.OPERATE, Event.CONTROL)})

_ALWAYS = {Event.QUICK_STOP: State.STOP, Event.FAULT: State.STOP, Event.SHUT_DOWN: State.OFF}
TRANSITIONS: Mapping[State, Mapping[Event, State]] = MappingProxyType(
    {
        State.INITIALISE: _ALWAYS | {Event.INITIALISED: State.OPERATE},
        State.OPERATE: _ALWAYS
        | {
            Event.CONFIGURE: State.CONFIGURE,
            Event.HOME: State.HOME,
            Event.JOG: State.JOG,
            Event.CONTROL: State.CONTROL,
        },
        State.CONFIGURE: _ALWAYS | {Event.SET: State.CONFIGURE, Event.CLOSE: State.OPERATE},
        State.HOME: _ALWAYS | {Event.START: State.HOMING, Event.CLOSE: State.OPERATE},
        State.HOMING: _ALWAYS
        | {Event.DONE: State.HOME, Event.HALT: State.HOMING, Event.LIMIT: State.HOMING},
        State.JOG: _ALWAYS | {Event.START: State.JOGGING, Event.CLOSE: State.OPERATE},
        State.JOGGING: _ALWAYS
        | {
            Event.START: State.JOGGING,  # another direction or speed
            Event.DONE: State.JOG,
            Event.HALT: State.JOGGING,
            Event.LIMIT: State.JOGGING,  # held; the way back is free
        },
        State.CONTROL: _ALWAYS | {Event.LOAD: State.LOADED, Event.CLOSE: State.OPERATE},
        State.LOADED: _ALWAYS
        | {Event.LOAD: State.LOADED, Event.START: State.EXECUTING, Event.CLOSE: State.OPERATE},
        State.EXECUTING: _ALWAYS
        | {Event.DONE: State.LOADED, Event.HALT: State.EXECUTING, Event.LIMIT: State.STOP},
        State.STOP: _ALWAYS | {Event.RESET: State.INITIALISE},
        State.OFF: {},
    }
)


class Refused(ValueError):
    """The event is not allowed in the state; says what is."""

    def __init__(self, state: State, event: Event, why: str = "") -> None:
        allowed = ", ".join(e for e in TRANSITIONS[state] if e in REQUESTS) or "nothing"
        super().__init__(why or f"{event} is refused in state {state}; allowed: {allowed}")


def follow(state: State, event: Event, *, homed: bool) -> State:
    """The state after ``event``. Raises Refused where there is none, or where the machine must be homed first."""
    if event not in TRANSITIONS[state]:
        raise Refused(state, event)
    if (state, event) in NEEDS_HOME and not homed:
        raise Refused(state, event, f"{event} needs a homed machine; open the home task first")
    return TRANSITIONS[state][event]
