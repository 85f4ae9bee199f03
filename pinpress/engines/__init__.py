"""Close loops, follow assemblies and solve for forces; they know arrays, joints and `pin.Model`, never a Linkage."""
