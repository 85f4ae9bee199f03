/*
@HEADER@
 */
#include "@FILE@.h"

#include <math.h> /* NAN */

typedef @NUMBER@ number;

/* Polynomials over panels of the driver's position. The first rows are those of the driving torque. */
enum { PANELS = @PANELS@, TERMS = @TERMS@, ROWS = @ROWS@, TORQUE_ROWS = @TORQUE_ROWS@ };
static const double PERIOD = @PERIOD@; /* [@UNIT@]; 0: the driver goes from the first border to the last */

static const double BORDERS[PANELS + 1] = {
@BORDERS@};

/* [panel][power of x][row] */
static const number TABLE[PANELS][TERMS][ROWS] = {
@TABLE@};

/* The panel of an angle, and the place x from -1 to 1 on it; -1 if the driver does not reach the angle. */
static int locate(double angle, double *x)
{
    int low = 0, high = PANELS;
    if (PERIOD > 0.0) {
        const double turns = (angle - BORDERS[0]) / PERIOD;
        long long whole;
        if (!(turns > -1e15 && turns < 1e15))
            return -1;
        whole = (long long)turns;
        angle -= PERIOD * (double)((double)whole > turns ? whole - 1 : whole);
    } else if (!(angle >= BORDERS[0] && angle <= BORDERS[PANELS])) {
        return -1;
    }
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (angle < BORDERS[middle])
            high = middle;
        else
            low = middle;
    }
    *x = 2.0 * (angle - BORDERS[low]) / (BORDERS[low + 1] - BORDERS[low]) - 1.0;
    return low;
}

int @PREFIX@_all(double angle, double speed, double acceleration, const double *inputs, double *outputs)
{
    double x, row[ROWS];
    const double square = speed * speed;
    const int panel = locate(angle, &x);
    int k, r;
    (void)inputs, (void)square, (void)speed, (void)acceleration;
    if (panel < 0) {
        for (k = 0; k < @MACRO@_OUTPUTS; k++)
            outputs[k] = NAN;
        return 1;
    }
    for (r = 0; r < ROWS; r++)
        row[r] = TABLE[panel][TERMS - 1][r];
    for (k = TERMS - 2; k >= 0; k--)
        for (r = 0; r < ROWS; r++)
            row[r] = row[r] * x + TABLE[panel][k][r];
@ALL@    return 0;
}

int @PREFIX@_acceleration(double angle, double speed, double torque, const double *inputs, double added_inertia, double *acceleration)
{
    double x, row[TORQUE_ROWS];
    const double square = speed * speed;
    const int panel = locate(angle, &x);
    int k, r;
    (void)inputs, (void)square, (void)speed;
    if (panel < 0) {
        *acceleration = NAN;
        return 1;
    }
    for (r = 0; r < TORQUE_ROWS; r++)
        row[r] = TABLE[panel][TERMS - 1][r];
    for (k = TERMS - 2; k >= 0; k--)
        for (r = 0; r < TORQUE_ROWS; r++)
            row[r] = row[r] * x + TABLE[panel][k][r];
    if (!(@REDUCED@ + added_inertia > 0.0)) {
        *acceleration = NAN;
        return 1;
    }
    *acceleration = (torque - (@STANDING@)) / (@REDUCED@ + added_inertia);
    return 0;
}

#ifdef @MACRO@_SELF_TEST
#include <stdio.h>
/* States of pinpress: angle, speed, acceleration, inputs, outputs. Compile this file alone with -D@MACRO@_SELF_TEST, and run it. */
enum { STATES = @STATES@, WIDTH = 3 + @MACRO@_INPUTS + @MACRO@_OUTPUTS };
static const double STATE[STATES][WIDTH] = {
@STATE@};
static const double LARGEST[@MACRO@_OUTPUTS] = {
@LARGEST@};

int main(void)
{
    int k, s;
    double worst = 0.0;
    for (s = 0; s < STATES; s++) {
        double outputs[@MACRO@_OUTPUTS];
        if (@PREFIX@_all(STATE[s][0], STATE[s][1], STATE[s][2], STATE[s] + 3, outputs) != 0)
            worst = 1.0;
        for (k = 0; k < @MACRO@_OUTPUTS; k++) {
            const double error = (outputs[k] - STATE[s][3 + @MACRO@_INPUTS + k]) / LARGEST[k];
            if (!(error <= worst && -error <= worst))
                worst = error < 0.0 ? -error : error;
        }
    }
    printf("@PREFIX@: %s, largest error %.1e of the largest value\n", worst <= @ALLOWED@ ? "passed" : "FAILED", worst);
    return worst <= @ALLOWED@ ? 0 : 1;
}
#endif
