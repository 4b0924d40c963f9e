"""The state machine, every state with every event."""

import itertools

import pytest

from gapscope.analysis.rig.states import (
    MOVING,
    NEEDS_HOME,
    REQUESTS,
    TRANSITIONS,
    Event,
    Refused,
    State,
    follow,
)

# Written out by hand, row by row: what a user may rely on. "-" is refused; the order is that of the events.
EVENTS = [
    "configure",
    "home",
    "jog",
    "control",
    "close",
    "set",
    "load",
    "start",
    "halt",
    "quick_stop",
    "reset",
    "shut_down",
    "initialised",
    "done",
    "limit",
    "fault",
]
TABLE = {
    "initialise": "- - - - - - - - - stop - off operate - - stop",
    "operate": "configure home jog control - - - - - stop - off - - - stop",
    "configure": "- - - - operate configure - - - stop - off - - - stop",
    "home": "- - - - operate - - homing - stop - off - - - stop",
    "homing": "- - - - - - - - homing stop - off - home homing stop",
    "jog": "- - - - operate - - jogging - stop - off - - - stop",
    "jogging": "- - - - - - - jogging jogging stop - off - jog jogging stop",
    "control": "- - - - operate - loaded - - stop - off - - - stop",
    "loaded": "- - - - operate - loaded executing - stop - off - - - stop",
    "executing": "- - - - - - - - executing stop - off - loaded stop stop",
    "stop": "- - - - - - - - - stop initialise off - - - stop",
    "off": "- - - - - - - - - - - - - - - -",
}


def test_the_table_covers_every_state_and_event():
    assert set(TABLE) == set(State)
    assert set(EVENTS) == set(Event)
    assert set(TRANSITIONS) == set(State)


@pytest.mark.parametrize(("state", "event"), list(itertools.product(State, Event)))
def test_every_state_with_every_event(state, event):
    expected = TABLE[state].split()[EVENTS.index(event)]
    if expected == "-":
        with pytest.raises(Refused, match=f"{event} is refused in state {state}; allowed: "):
            follow(state, event, homed=True)
    else:
        assert follow(state, event, homed=True) == expected
        if (state, event) in NEEDS_HOME:
            with pytest.raises(Refused, match="needs a homed machine"):
                follow(state, event, homed=False)
        else:
            assert follow(state, event, homed=False) == expected


def test_quick_stop_fault_and_shut_down_are_always_heard():
    for state in set(State) - {State.OFF}:
        assert follow(state, Event.QUICK_STOP, homed=False) is State.STOP
        assert follow(state, Event.FAULT, homed=False) is State.STOP
        assert follow(state, Event.SHUT_DOWN, homed=False) is State.OFF


def test_nothing_moves_out_of_a_stop_but_by_reset_and_home():
    """The shortest way from stop to a trajectory leads through a reset, which forgets the home position."""
    assert [e for e in REQUESTS if e in TRANSITIONS[State.STOP]] == [
        Event.QUICK_STOP,
        Event.RESET,
        Event.SHUT_DOWN,
    ]
    ways_in = {
        s for s in State for e, t in TRANSITIONS[s].items() if t in MOVING and s not in MOVING
    }
    assert ways_in == {State.HOME, State.JOG, State.LOADED}
    assert {e for s in ways_in for e, t in TRANSITIONS[s].items() if t in MOVING} == {Event.START}


def test_every_state_can_be_reached_and_left():
    reached, waiting = {State.INITIALISE}, [State.INITIALISE]
    while waiting:
        for after in TRANSITIONS[waiting.pop()].values():
            if after not in reached:
                reached.add(after)
                waiting.append(after)
    assert reached == set(State)
