"""Measures of planar linkages alone: transmission angles, poles, polygons and kinds of four-bars."""
