/*
@HEADER@
 */
#ifndef @MACRO@_H
#define @MACRO@_H

#ifdef __cplusplus
extern "C" {
#endif

enum { @MACRO@_INPUTS = @INPUTS@, @MACRO@_OUTPUTS = @OUTPUTS@ };

/* Places in `inputs`: forces [N] and moments [N m] */
@INPUT_PLACES@
/* Places in `outputs`; components of vectors that are not here are zero. */
@OUTPUT_PLACES@
/* All outputs in one state. Angle [@UNIT@], speed [@UNIT@/s] and acceleration [@UNIT@/s2] are of the driver. Returns 0; 1 with NaN in all
   outputs if the driver does not reach the angle. Needs no memory but the stack, and keeps none. */
int @PREFIX@_all(double angle, double speed, double acceleration, const double *inputs, double *outputs);

/* Equation of motion: the driver's acceleration [@UNIT@/s2] under a torque [@EFFORT@], with the inertia [@INERTIA@] of flywheel and drive at
   the driver. Returns 0; 1 with NaN if the driver does not reach the angle, or if no inertia resists the torque. */
int @PREFIX@_acceleration(double angle, double speed, double torque, const double *inputs, double added_inertia, double *acceleration);

#ifdef __cplusplus
}
#endif
#endif
