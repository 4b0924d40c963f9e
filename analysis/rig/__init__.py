"""A virtual rig: a machine of the toolbox behind a position controller, to practise a session on.

After appendix A of Roldan 2017 (a real-time position controller for parallel machines): a server that paces a
position controller in real time, a client that drives it, one task at a time, and a state machine for both.

1. ``states``      the state machine, as data;
2. ``machine``     what a machine must offer; ``machines`` lists those that do, one for every kind of log set. ``chain`` is
   any parallel machine, ``drive_machine`` any drive, ``model`` any robot with a model file, whose limits, loops and
   home are in ``model_layout``; the others are one module each;
3. ``controller``  the rig: requests, setpoints, limit switches, quick stop, acquisition;
4. ``recorder``    finished runs as log sets that ``gapscope diagnose`` reads;
5. ``pacing``, ``server``  real time, and the web page on localhost.

Not modelled: hard stops behind the switches, and the field bus between controller and amplifiers.
"""
