"""A press whose slide two servo motors move, as a table of pins."""

TWO_SERVOS = """
press: two_servos
units: mm
frame: A B
pins:
  A: [-300, 0]
  B: [300, 0]
  P: {from: A, length: 120, angle: 200}
  Q: {from: B, length: 120, angle: -20}
  C: {P: 620, Q: 620, side: down}
  D: C
  S: {C: 300, x: 0, side: down}
links:
  crank_1: {pins: A P, section: 120 x 80}
  crank_2: {pins: B Q, section: 120 x 80}
  coupler_1: {pins: P C, section: 100 x 60}
  coupler_2: {pins: Q C D, section: 100 x 60}
  rod: {pins: D S, section: 100 x 60}
  slide: {pins: S, guide: up, mass: 500}
drive: [A, B]
"""
