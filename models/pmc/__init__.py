r"""The PepperMill-Carrier (PMC): two limbs, four freedoms, Schoenflies motion.

World frame W: origin O halfway between the two C-drives, x along the axis of drive 1, y along the
axis of drive 2, z up. Drive 1 lies at height :math:`-b_0` and drive 2 at :math:`+b_0`.

1. Pose :math:`(x, y, z, \phi)` of the PepperMill (PM): its centre C in W [m] and the screw angle
   [rad]. With a right-handed lower and a left-handed upper screw the PM turns by :math:`-\phi` about
   +z (the thesis leaves the sign open).
2. Joints :math:`(d_1, d_2, \theta_1, \theta_2)`: carriage positions [m] and right-handed angles of
   the proximal links about the drive axes [rad]; :math:`\theta_1` starts at +y, :math:`\theta_2` at +z.
3. Each limb moves in a vertical plane: elevation :math:`\alpha` of its proximal link
   (:math:`\alpha_1 = \theta_1`, :math:`\alpha_2 = \pi/2 - \theta_2`, eq. 2.19), elevation
   :math:`\beta` of its distal link, reach h (:math:`y` for limb 1, :math:`x` for limb 2) and height v
   of the wrist P over the drive axis.
4. The screws give :math:`v_1 = z + b_0 + p\phi` and :math:`v_2 = z - b_0 - p\phi` (2.13c).

Modules: ``geometry`` and ``parameters`` (numbers), ``limb`` and ``displacement`` (laws), ``kinematics`` (arrays),
``limits`` (joint limits of chapter 2), ``dynamics`` and ``constants`` (equations of motion), ``description`` (SDF; its
output for the prototype is ``pmc.sdf`` with ``closures.yaml``), ``cycle`` (test cycles), ``control``, ``controllers`` and
``simulation`` (closed loop). Not modelled in them: clearance, compliance.

Source: T. Friedlaender, Design, Control and Testing of a Pick-and-Place Robot and its Novel
Actuators, M.Eng. thesis, McGill University 2015, chapters 2 and 3.
"""
