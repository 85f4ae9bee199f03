"""Engines close loops, follow assemblies and solve for forces. They know arrays, joints and `pin.Model`, never a Linkage."""
