/*
@HEADER@
 *
 * FMI 2.0 for Model Exchange and Co-Simulation. The types and functions are those of the standard, which is why no header of it is needed.
 */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "@FILE@.h"

typedef void *fmi2Component, *fmi2ComponentEnvironment, *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer, fmi2Boolean;
typedef char fmi2Char, fmi2Byte;
typedef const fmi2Char *fmi2String;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;
typedef struct {
    void (*logger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
    void *(*allocateMemory)(size_t, size_t);
    void (*freeMemory)(void *);
    void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;
typedef struct {
    fmi2Boolean newDiscreteStatesNeeded, terminateSimulation, nominalsOfContinuousStatesChanged, valuesOfContinuousStatesChanged;
    fmi2Boolean nextEventTimeDefined;
    fmi2Real nextEventTime;
} fmi2EventInfo;

#if defined _WIN32 || defined __CYGWIN__
#define EXPORTED __declspec(dllexport)
#else
#define EXPORTED __attribute__((visibility("default")))
#endif
#define JOINED(a, b) a##b
#define PREFIXED(prefix, name) JOINED(prefix, name)
#ifdef FMI2_FUNCTION_PREFIX /* of importers that link several FMUs statically */
#define FMI(name) PREFIXED(FMI2_FUNCTION_PREFIX, name)
#else
#define FMI(name) name
#endif
#define STATUS EXPORTED fmi2Status

/* References of values: states, their derivatives, inputs, parameters, then the outputs of the press. */
enum { ANGLE, DER_ANGLE, SPEED, ACCELERATION, TORQUE, INPUT, INERTIA = INPUT + @MACRO@_INPUTS, TOLERANCE, OUTPUT };
enum { END = OUTPUT + @MACRO@_OUTPUTS };

typedef struct {
    double time, angle, speed, torque, inertia, tolerance;
    double step;                       /* that the error allows, kept from one communication step to the next [s]; 0: not known yet */
    double inputs[@MACRO@_INPUTS + 1]; /* and one more, as C has no arrays without elements */
} State;

typedef struct {
    State state;
    const fmi2CallbackFunctions *callbacks;
    char *name;
} Press;

static fmi2Status refuse(const Press *press, const char *message)
{
    if (press->callbacks->logger != NULL)
        press->callbacks->logger(press->callbacks->componentEnvironment, press->name, fmi2Error, "logStatusError", "%s", message);
    return fmi2Error;
}

static const char BEYOND[] = "@NAME@: the driver has left the range of the table, or no inertia resists the torque";

/* Slopes of angle and speed; 1 if the table does not reach the angle. */
static int slopes(const State *s, double angle, double speed, double slope[2])
{
    slope[0] = speed;
    return @PREFIX@_acceleration(angle, speed, s->torque, s->inputs, s->inertia, &slope[1]);
}

/* From now to a time by the embedded pair of Dormand and Prince (1980) of orders 5 and 4; inputs are constant until then. */
static const char *advance(State *s, double until)
{
    static const double A[7][6] = {
        {0},
        {1.0 / 5},
        {3.0 / 40, 9.0 / 40},
        {44.0 / 45, -56.0 / 15, 32.0 / 9},
        {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
        {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
        {35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84},
    };
    static const double E[7] = {71.0 / 57600, 0.0, -71.0 / 16695, 71.0 / 1920, -17253.0 / 339200, 22.0 / 525, -1.0 / 40};
    double k[7][2];
    if (slopes(s, s->angle, s->speed, k[0]) != 0)
        return BEYOND;
    while (s->time < until) {
        const double left = until - s->time, wanted = s->step > 0.0 ? s->step : left;
        const int last = wanted >= left;
        const double h = last ? left : wanted;
        double y[2] = {0.0, 0.0}, error = 0.0, factor;
        int outside = 0, i, j, n;
        for (i = 1; i < 7 && !outside; i++) {
            y[0] = s->angle, y[1] = s->speed;
            for (j = 0; j < i; j++)
                for (n = 0; n < 2; n++)
                    y[n] += h * A[i][j] * k[j][n];
            outside = slopes(s, y[0], y[1], k[i]);
        }
        if (!outside)
            for (n = 0; n < 2; n++) {
                double missed = 0.0;
                for (i = 0; i < 7; i++)
                    missed += h * E[i] * k[i][n];
                error = fmax(error, fabs(missed) / (s->tolerance * fmax(1.0, fabs(y[n]))));
            }
        if (outside || !(error <= 1.0)) {
            s->step = h * (outside || !(error < HUGE_VAL) ? 0.2 : fmax(0.2, 0.9 * pow(error, -0.2)));
            if (s->time + s->step <= s->time)
                return outside ? BEYOND : "@NAME@: the tolerance cannot be kept; give a larger one";
            continue;
        }
        s->time = last ? until : s->time + h;
        s->angle = y[0], s->speed = y[1];
        k[0][0] = k[6][0], k[0][1] = k[6][1]; /* the last slopes are the first of the next step */
        factor = error > 0.0 ? fmin(5.0, 0.9 * pow(error, -0.2)) : 5.0;
        s->step = last ? fmax(wanted, h * factor) : h * factor;
    }
    return NULL;
}

static void start(State *s)
{
    memset(s, 0, sizeof *s);
    s->angle = @ANGLE@;
    s->tolerance = @TOLERANCE@;
}

/* ---------------------------------------------------------------------------------------------------------------- both kinds of FMU */

EXPORTED const char *FMI(fmi2GetTypesPlatform)(void) { return "default"; }
EXPORTED const char *FMI(fmi2GetVersion)(void) { return "2.0"; }

EXPORTED fmi2Component FMI(fmi2Instantiate)(
    fmi2String name, fmi2Type type, fmi2String guid, fmi2String place, const fmi2CallbackFunctions *callbacks, fmi2Boolean visible,
    fmi2Boolean logging)
{
    Press *press;
    (void)type, (void)place, (void)visible, (void)logging;
    if (callbacks == NULL || guid == NULL || strcmp(guid, "@GUID@") != 0) {
        if (callbacks != NULL && callbacks->logger != NULL)
            callbacks->logger(
                callbacks->componentEnvironment, name, fmi2Error, "logStatusError", "modelDescription.xml is not that of this binary");
        return NULL;
    }
    press = (Press *)calloc(1, sizeof *press);
    if (press == NULL)
        return NULL;
    press->name = (char *)calloc(name == NULL ? 1 : strlen(name) + 1, 1);
    if (press->name == NULL) {
        free(press);
        return NULL;
    }
    if (name != NULL)
        strcpy(press->name, name);
    press->callbacks = callbacks;
    start(&press->state);
    return press;
}

EXPORTED void FMI(fmi2FreeInstance)(fmi2Component c)
{
    if (c != NULL)
        free(((Press *)c)->name);
    free(c);
}

STATUS FMI(fmi2SetDebugLogging)(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[])
{
    return (void)c, (void)on, (void)n, (void)categories, fmi2OK;
}

STATUS FMI(fmi2SetupExperiment)(fmi2Component c, fmi2Boolean given, fmi2Real tolerance, fmi2Real begin, fmi2Boolean ends, fmi2Real end)
{
    (void)given, (void)tolerance, (void)ends, (void)end; /* the tolerance is a parameter */
    ((Press *)c)->state.time = begin;
    return fmi2OK;
}

STATUS FMI(fmi2EnterInitializationMode)(fmi2Component c) { return (void)c, fmi2OK; }

STATUS FMI(fmi2ExitInitializationMode)(fmi2Component c)
{
    const State *s = &((Press *)c)->state;
    double slope[2];
    return slopes(s, s->angle, s->speed, slope) != 0 ? refuse((Press *)c, BEYOND) : fmi2OK;
}

STATUS FMI(fmi2Terminate)(fmi2Component c) { return (void)c, fmi2OK; }

STATUS FMI(fmi2Reset)(fmi2Component c)
{
    start(&((Press *)c)->state);
    return fmi2OK;
}

STATUS FMI(fmi2GetReal)(fmi2Component c, const fmi2ValueReference references[], size_t count, fmi2Real values[])
{
    const State *s = &((Press *)c)->state;
    double outputs[@MACRO@_OUTPUTS], slope[2] = {0.0, 0.0};
    int outside = 0;
    size_t k;
    for (k = 0; k < count && !outside; k++)
        if (references[k] == ACCELERATION || references[k] >= OUTPUT) { /* once for all */
            outside = slopes(s, s->angle, s->speed, slope) || @PREFIX@_all(s->angle, s->speed, slope[1], s->inputs, outputs);
            break;
        }
    if (outside)
        return refuse((Press *)c, BEYOND);
    for (k = 0; k < count; k++) {
        const fmi2ValueReference r = references[k];
        if (r >= END)
            return refuse((Press *)c, "@NAME@: there is no value with this reference");
        values[k] = r >= OUTPUT        ? outputs[r - OUTPUT]
                    : r == TOLERANCE    ? s->tolerance
                    : r == INERTIA      ? s->inertia
                    : r >= INPUT        ? s->inputs[r - INPUT]
                    : r == TORQUE       ? s->torque
                    : r == ACCELERATION ? slope[1]
                    : r == ANGLE        ? s->angle
                                        : s->speed; /* which is the slope of the angle too */
    }
    return fmi2OK;
}

STATUS FMI(fmi2SetReal)(fmi2Component c, const fmi2ValueReference references[], size_t count, const fmi2Real values[])
{
    State *s = &((Press *)c)->state;
    size_t k;
    for (k = 0; k < count; k++) {
        const fmi2ValueReference r = references[k];
        const double value = values[k];
        if (!(fabs(value) < HUGE_VAL))
            return refuse((Press *)c, "@NAME@: a value is not finite");
        if ((r == INERTIA && value < 0.0) || (r == TOLERANCE && !(value >= 1e-14 && value <= 1e-2)))
            return refuse((Press *)c, "@NAME@: added_inertia may not be negative, and tolerance is from 1e-14 to 1e-2");
        if (r == ANGLE)
            s->angle = value;
        else if (r == SPEED)
            s->speed = value;
        else if (r == TORQUE)
            s->torque = value;
        else if (r >= INPUT && r < INERTIA)
            s->inputs[r - INPUT] = value;
        else if (r == INERTIA)
            s->inertia = value;
        else if (r == TOLERANCE)
            s->tolerance = value;
        else
            return refuse((Press *)c, "@NAME@: this value cannot be set");
    }
    return fmi2OK;
}

/* There are no values of these types. */
#define NO_VALUES(name, type)                                                                           \
    STATUS FMI(name)(fmi2Component c, const fmi2ValueReference r[], size_t n, type v[])                 \
    {                                                                                                   \
        return (void)c, (void)r, (void)v, n ? fmi2Error : fmi2OK;                                       \
    }
NO_VALUES(fmi2GetInteger, fmi2Integer)
NO_VALUES(fmi2GetBoolean, fmi2Boolean)
NO_VALUES(fmi2GetString, fmi2String)
NO_VALUES(fmi2SetInteger, const fmi2Integer)
NO_VALUES(fmi2SetBoolean, const fmi2Boolean)
NO_VALUES(fmi2SetString, const fmi2String)

STATUS FMI(fmi2GetFMUstate)(fmi2Component c, fmi2FMUstate *kept)
{
    if (*kept == NULL)
        *kept = malloc(sizeof(State));
    if (*kept == NULL)
        return refuse((Press *)c, "@NAME@: out of memory");
    memcpy(*kept, &((Press *)c)->state, sizeof(State));
    return fmi2OK;
}
STATUS FMI(fmi2SetFMUstate)(fmi2Component c, fmi2FMUstate kept)
{
    memcpy(&((Press *)c)->state, kept, sizeof(State));
    return fmi2OK;
}
STATUS FMI(fmi2FreeFMUstate)(fmi2Component c, fmi2FMUstate *kept)
{
    (void)c;
    free(*kept);
    *kept = NULL;
    return fmi2OK;
}
STATUS FMI(fmi2SerializedFMUstateSize)(fmi2Component c, fmi2FMUstate kept, size_t *size)
{
    return (void)c, (void)kept, *size = sizeof(State), fmi2OK;
}
STATUS FMI(fmi2SerializeFMUstate)(fmi2Component c, fmi2FMUstate kept, fmi2Byte bytes[], size_t size)
{
    if (size != sizeof(State))
        return refuse((Press *)c, "@NAME@: a state has another size");
    memcpy(bytes, kept, size);
    return fmi2OK;
}
STATUS FMI(fmi2DeSerializeFMUstate)(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *kept)
{
    if (size != sizeof(State))
        return refuse((Press *)c, "@NAME@: a state has another size");
    *kept = malloc(size);
    if (*kept == NULL)
        return refuse((Press *)c, "@NAME@: out of memory");
    memcpy(*kept, bytes, size);
    return fmi2OK;
}

STATUS FMI(fmi2GetDirectionalDerivative)(
    fmi2Component c, const fmi2ValueReference u[], size_t nu, const fmi2ValueReference k[], size_t nk, const fmi2Real dk[], fmi2Real du[])
{
    (void)u, (void)nu, (void)k, (void)nk, (void)dk, (void)du;
    return refuse((Press *)c, "@NAME@: it gives no directional derivatives");
}

/* ------------------------------------------------------------------------------------------------------------------- Model Exchange */

STATUS FMI(fmi2EnterEventMode)(fmi2Component c) { return (void)c, fmi2OK; }
STATUS FMI(fmi2NewDiscreteStates)(fmi2Component c, fmi2EventInfo *info)
{
    (void)c;
    memset(info, 0, sizeof *info);
    return fmi2OK;
}
STATUS FMI(fmi2EnterContinuousTimeMode)(fmi2Component c) { return (void)c, fmi2OK; }
STATUS FMI(fmi2CompletedIntegratorStep)(fmi2Component c, fmi2Boolean kept, fmi2Boolean *event, fmi2Boolean *ends)
{
    return (void)c, (void)kept, *event = 0, *ends = 0, fmi2OK;
}
STATUS FMI(fmi2SetTime)(fmi2Component c, fmi2Real time)
{
    ((Press *)c)->state.time = time;
    return fmi2OK;
}
STATUS FMI(fmi2SetContinuousStates)(fmi2Component c, const fmi2Real x[], size_t count)
{
    if (count != 2)
        return refuse((Press *)c, "@NAME@: it has two states, angle and speed");
    ((Press *)c)->state.angle = x[0];
    ((Press *)c)->state.speed = x[1];
    return fmi2OK;
}
STATUS FMI(fmi2GetDerivatives)(fmi2Component c, fmi2Real derivatives[], size_t count)
{
    const State *s = &((Press *)c)->state;
    if (count != 2)
        return refuse((Press *)c, "@NAME@: it has two states, angle and speed");
    return slopes(s, s->angle, s->speed, derivatives) != 0 ? refuse((Press *)c, BEYOND) : fmi2OK;
}
STATUS FMI(fmi2GetEventIndicators)(fmi2Component c, fmi2Real indicators[], size_t count)
{
    return (void)c, (void)indicators, count ? fmi2Error : fmi2OK;
}
STATUS FMI(fmi2GetContinuousStates)(fmi2Component c, fmi2Real x[], size_t count)
{
    if (count != 2)
        return refuse((Press *)c, "@NAME@: it has two states, angle and speed");
    x[0] = ((Press *)c)->state.angle;
    x[1] = ((Press *)c)->state.speed;
    return fmi2OK;
}
STATUS FMI(fmi2GetNominalsOfContinuousStates)(fmi2Component c, fmi2Real x[], size_t count)
{
    size_t k;
    (void)c;
    for (k = 0; k < count; k++)
        x[k] = 1.0;
    return fmi2OK;
}

/* -------------------------------------------------------------------------------------------------------------------- Co-Simulation */

STATUS FMI(fmi2DoStep)(fmi2Component c, fmi2Real now, fmi2Real step, fmi2Boolean final)
{
    Press *press = (Press *)c;
    const char *problem;
    (void)final;
    press->state.time = now;
    problem = advance(&press->state, now + step);
    return problem == NULL ? fmi2OK : refuse(press, problem);
}
STATUS FMI(fmi2CancelStep)(fmi2Component c) { return refuse((Press *)c, "@NAME@: steps are complete when they return"); }
STATUS FMI(fmi2SetRealInputDerivatives)(
    fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer order[], const fmi2Real v[])
{
    (void)r, (void)order, (void)v;
    return n ? refuse((Press *)c, "@NAME@: inputs are constant over a step") : fmi2OK;
}
STATUS FMI(fmi2GetRealOutputDerivatives)(
    fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer order[], fmi2Real v[])
{
    (void)r, (void)order, (void)v;
    return n ? refuse((Press *)c, "@NAME@: it gives no derivatives of outputs") : fmi2OK;
}
STATUS FMI(fmi2GetRealStatus)(fmi2Component c, fmi2StatusKind kind, fmi2Real *value)
{
    if (kind != fmi2LastSuccessfulTime)
        return fmi2Discard;
    *value = ((Press *)c)->state.time;
    return fmi2OK;
}
#define NO_STATUS(name, type)                                                                           \
    STATUS FMI(name)(fmi2Component c, const fmi2StatusKind kind, type *value)                           \
    {                                                                                                   \
        return (void)c, (void)kind, (void)value, fmi2Discard;                                           \
    }
NO_STATUS(fmi2GetStatus, fmi2Status)
NO_STATUS(fmi2GetIntegerStatus, fmi2Integer)
NO_STATUS(fmi2GetBooleanStatus, fmi2Boolean)
NO_STATUS(fmi2GetStringStatus, fmi2String)
