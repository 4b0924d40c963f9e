"""What a machine is: equations of motion, friction and actuator laws, kinematics, parameters.

Pure functions and dataclasses; nothing here knows of Drake systems.
"""
