/* FMI 3.0 for Co-Simulation around one exported program. What the standard declares is declared here in our own
   words, so that this folder compiles without other files. Where several FMUs are linked into one program,
   -DFUNCTION_PREFIX=name_ tells their functions apart. */
#include "instance.h"
#include <stdbool.h>
#include <stdint.h>

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } status;
typedef enum { INDEPENDENT, CONSTANT, FIXED, TUNABLE, DISCRETE, DEPENDENT } dependency;
typedef enum { NOT_YET_KNOWN, UNCHANGED, CHANGED } qualifier;
typedef const char *string;
typedef const uint8_t *binary;
typedef bool truth;
typedef void (*logger)(void *environment, status how, string category, string message);
typedef void (*intermediate)(void *environment, double time, bool set, bool get, bool finished, bool can_return,
                             bool *return_early, double *when);

static status said(int well) { return well ? OK : ERROR; }

static void tell(const struct instance *me, enum severity severity, const char *sentence)
{
    logger log;
    memcpy(&log, &me->callback, sizeof log);
    if (log == NULL || (severity == WARNED && !me->chatty)) return;
    log(me->environment, severity == FAILED ? ERROR : WARNING,
        severity == FAILED ? "logStatusError" : "logStatusWarning", sentence);
}

static status not_offered(const struct instance *me, const char *what)
{
    return said(fail(me, "%s is not offered, as the description of this FMU says", what));
}

EXPORT(string, fmi3GetVersion)(void) { return "3.0"; }

EXPORT(status, fmi3SetDebugLogging)(void *c, bool on, UNUSED size_t count, UNUSED const string categories[])
{
    ((struct instance *)c)->chatty = on;
    return OK;
}

EXPORT(void *, fmi3InstantiateCoSimulation)(string name, string token, UNUSED string resources, UNUSED bool visible,
                                            bool logging, bool events, UNUSED bool early,
                                            UNUSED const uint32_t required[], size_t requirements, void *environment,
                                            logger log, UNUSED intermediate update)
{
    struct instance *me = events || requirements > 0 ? NULL : make(name, token);
    if (me == NULL) {
        if (log != NULL)
            log(environment, ERROR, "logStatusError",
                "the instance could not be made: co-simulation without events and intermediate variables, with the "
                "token of this FMU's own description, is offered");
        return NULL;
    }
    memcpy(&me->callback, &log, sizeof log);
    me->environment = environment;
    me->tell = tell;
    me->chatty = logging;
    return me;
}
EXPORT(void *, fmi3InstantiateModelExchange)(UNUSED string name, UNUSED string token, UNUSED string resources,
                                             UNUSED bool visible, UNUSED bool logging, UNUSED void *environment,
                                             UNUSED logger log)
{
    return NULL;
}
EXPORT(void *, fmi3InstantiateScheduledExecution)(UNUSED string name, UNUSED string token, UNUSED string resources,
                                                  UNUSED bool visible, UNUSED bool logging, UNUSED void *environment,
                                                  UNUSED logger log, UNUSED void (*update)(void *environment),
                                                  UNUSED void (*lock)(void), UNUSED void (*unlock)(void))
{
    return NULL;
}
EXPORT(void, fmi3FreeInstance)(void *c) { free(c); }

EXPORT(status, fmi3EnterInitializationMode)(void *c, UNUSED bool tolerant, UNUSED double tolerance, double start,
                                            UNUSED bool ends, UNUSED double stop)
{
    return said(begin_at(c, start) && enter(c, INSTANTIATED, INITIALISING, "fmi3EnterInitializationMode"));
}
EXPORT(status, fmi3ExitInitializationMode)(void *c)
{
    return said(enter(c, INITIALISING, STEPPING, "fmi3ExitInitializationMode"));
}
EXPORT(status, fmi3EnterStepMode)(void *c) { return not_offered(c, "event mode"); }
EXPORT(status, fmi3EnterEventMode)(void *c) { return not_offered(c, "event mode"); }
EXPORT(status, fmi3EnterConfigurationMode)(void *c) { return not_offered(c, "configuration mode"); }
EXPORT(status, fmi3ExitConfigurationMode)(void *c) { return not_offered(c, "configuration mode"); }
EXPORT(status, fmi3Terminate)(void *c) { return said(enter(c, STEPPING, TERMINATED, "fmi3Terminate")); }
EXPORT(status, fmi3Reset)(void *c)
{
    begin_anew(&((struct instance *)c)->now);
    return OK;
}

EXPORT(status, fmi3GetFloat64)(void *c, const uint32_t vr[], size_t n, double values[], size_t count)
{
    return said((n == count || fail(c, "%lu values for %lu variables", (unsigned long)count, (unsigned long)n)) &&
                get(c, vr, n, values));
}
EXPORT(status, fmi3SetFloat64)(void *c, const uint32_t vr[], size_t n, const double values[], size_t count)
{
    return said((n == count || fail(c, "%lu values for %lu variables", (unsigned long)count, (unsigned long)n)) &&
                set(c, vr, n, values));
}

/* There are variables of no other type: asking for none is well. */
static status none(const struct instance *me, size_t n, const char *type)
{
    return said(n == 0 || fail(me, "a variable of type %s was asked for, and this FMU has none", type));
}
#define NO_VARIABLES(name, type) \
    EXPORT(status, fmi3Get##name)(void *c, UNUSED const uint32_t vr[], size_t n, UNUSED type values[], \
                                  UNUSED size_t count) \
    { \
        return none(c, n, #name); \
    } \
    EXPORT(status, fmi3Set##name)(void *c, UNUSED const uint32_t vr[], size_t n, UNUSED const type values[], \
                                  UNUSED size_t count) \
    { \
        return none(c, n, #name); \
    }
NO_VARIABLES(Float32, float)
NO_VARIABLES(Int8, int8_t)
NO_VARIABLES(UInt8, uint8_t)
NO_VARIABLES(Int16, int16_t)
NO_VARIABLES(UInt16, uint16_t)
NO_VARIABLES(Int32, int32_t)
NO_VARIABLES(UInt32, uint32_t)
NO_VARIABLES(Int64, int64_t)
NO_VARIABLES(UInt64, uint64_t)
NO_VARIABLES(Boolean, truth)
NO_VARIABLES(String, string)

EXPORT(status, fmi3GetBinary)(void *c, UNUSED const uint32_t vr[], size_t n, UNUSED size_t sizes[],
                              UNUSED binary values[], UNUSED size_t count)
{
    return none(c, n, "Binary");
}
EXPORT(status, fmi3SetBinary)(void *c, UNUSED const uint32_t vr[], size_t n, UNUSED const size_t sizes[],
                              UNUSED const binary values[], UNUSED size_t count)
{
    return none(c, n, "Binary");
}
EXPORT(status, fmi3GetClock)(void *c, UNUSED const uint32_t vr[], size_t n, UNUSED bool values[])
{
    return none(c, n, "Clock");
}
EXPORT(status, fmi3SetClock)(void *c, UNUSED const uint32_t vr[], size_t n, UNUSED const bool values[])
{
    return none(c, n, "Clock");
}

EXPORT(status, fmi3GetNumberOfVariableDependencies)(void *c, UNUSED uint32_t vr, UNUSED size_t *count)
{
    return not_offered(c, "the list of dependencies");
}
EXPORT(status, fmi3GetVariableDependencies)(void *c, UNUSED uint32_t vr, UNUSED size_t of[], UNUSED uint32_t on[],
                                            UNUSED size_t elements[], UNUSED dependency kinds[], UNUSED size_t count)
{
    return not_offered(c, "the list of dependencies");
}

EXPORT(status, fmi3GetFMUState)(void *c, void **state) { return said(store(c, state)); }
EXPORT(status, fmi3SetFMUState)(void *c, void *state) { return said(restore(c, state)); }
EXPORT(status, fmi3FreeFMUState)(UNUSED void *c, void **state)
{
    free(*state);
    *state = NULL;
    return OK;
}
EXPORT(status, fmi3SerializedFMUStateSize)(UNUSED void *c, UNUSED void *state, size_t *size)
{
    *size = STORED;
    return OK;
}
EXPORT(status, fmi3SerializeFMUState)(void *c, void *state, uint8_t bytes[], size_t size)
{
    return said(write_state(c, state, bytes, size));
}
EXPORT(status, fmi3DeserializeFMUState)(void *c, const uint8_t bytes[], size_t size, void **state)
{
    return said(read_state(c, bytes, size, state));
}

EXPORT(status, fmi3GetDirectionalDerivative)(void *c, UNUSED const uint32_t unknown[], UNUSED size_t unknowns,
                                             UNUSED const uint32_t known[], UNUSED size_t knowns,
                                             UNUSED const double seed[], UNUSED size_t seeds,
                                             UNUSED double derivative[], UNUSED size_t derivatives)
{
    return not_offered(c, "a directional derivative");
}
EXPORT(status, fmi3GetAdjointDerivative)(void *c, UNUSED const uint32_t unknown[], UNUSED size_t unknowns,
                                         UNUSED const uint32_t known[], UNUSED size_t knowns,
                                         UNUSED const double seed[], UNUSED size_t seeds, UNUSED double derivative[],
                                         UNUSED size_t derivatives)
{
    return not_offered(c, "an adjoint derivative");
}
EXPORT(status, fmi3GetOutputDerivatives)(void *c, UNUSED const uint32_t vr[], UNUSED size_t n,
                                         UNUSED const int32_t orders[], UNUSED double values[], UNUSED size_t count)
{
    return not_offered(c, "a derivative of an output");
}

/* Clocks and discrete states, of which there are none. */
EXPORT(status, fmi3GetIntervalDecimal)(void *c, UNUSED const uint32_t vr[], size_t n, UNUSED double intervals[],
                                       UNUSED qualifier qualifiers[])
{
    return none(c, n, "Clock");
}
EXPORT(status, fmi3GetIntervalFraction)(void *c, UNUSED const uint32_t vr[], size_t n, UNUSED uint64_t counters[],
                                        UNUSED uint64_t resolutions[], UNUSED qualifier qualifiers[])
{
    return none(c, n, "Clock");
}
EXPORT(status, fmi3GetShiftDecimal)(void *c, UNUSED const uint32_t vr[], size_t n, UNUSED double shifts[])
{
    return none(c, n, "Clock");
}
EXPORT(status, fmi3GetShiftFraction)(void *c, UNUSED const uint32_t vr[], size_t n, UNUSED uint64_t counters[],
                                     UNUSED uint64_t resolutions[])
{
    return none(c, n, "Clock");
}
EXPORT(status, fmi3SetIntervalDecimal)(void *c, UNUSED const uint32_t vr[], size_t n, UNUSED const double intervals[])
{
    return none(c, n, "Clock");
}
EXPORT(status, fmi3SetIntervalFraction)(void *c, UNUSED const uint32_t vr[], size_t n,
                                        UNUSED const uint64_t counters[], UNUSED const uint64_t resolutions[])
{
    return none(c, n, "Clock");
}
EXPORT(status, fmi3SetShiftDecimal)(void *c, UNUSED const uint32_t vr[], size_t n, UNUSED const double shifts[])
{
    return none(c, n, "Clock");
}
EXPORT(status, fmi3SetShiftFraction)(void *c, UNUSED const uint32_t vr[], size_t n, UNUSED const uint64_t counters[],
                                     UNUSED const uint64_t resolutions[])
{
    return none(c, n, "Clock");
}
EXPORT(status, fmi3EvaluateDiscreteStates)(void *c) { return not_offered(c, "event mode"); }
EXPORT(status, fmi3UpdateDiscreteStates)(void *c, UNUSED bool *again, UNUSED bool *terminate, UNUSED bool *nominals,
                                         UNUSED bool *states, UNUSED bool *next_defined, UNUSED double *next)
{
    return not_offered(c, "event mode");
}

EXPORT(status, fmi3DoStep)(void *c, double from, double length, UNUSED bool no_way_back, bool *events,
                           bool *terminate, bool *early, double *reached)
{
    int well = advance(c, from, length);
    *events = *terminate = *early = false;
    *reached = ((struct instance *)c)->now.reached;
    return said(well);
}

/* Model exchange and scheduled execution, which are not offered; some hosts look for the names all the same. */
EXPORT(status, fmi3EnterContinuousTimeMode)(void *c) { return not_offered(c, "model exchange"); }
EXPORT(status, fmi3CompletedIntegratorStep)(void *c, UNUSED bool no_way_back, UNUSED bool *event, UNUSED bool *end)
{
    return not_offered(c, "model exchange");
}
EXPORT(status, fmi3SetTime)(void *c, UNUSED double time) { return not_offered(c, "model exchange"); }
EXPORT(status, fmi3SetContinuousStates)(void *c, UNUSED const double states[], UNUSED size_t count)
{
    return not_offered(c, "model exchange");
}
#define OF_CONTINUOUS_STATES(name) \
    EXPORT(status, fmi3Get##name)(void *c, UNUSED double values[], UNUSED size_t count) \
    { \
        return not_offered(c, "model exchange"); \
    }
OF_CONTINUOUS_STATES(ContinuousStates)
OF_CONTINUOUS_STATES(ContinuousStateDerivatives)
OF_CONTINUOUS_STATES(NominalsOfContinuousStates)
OF_CONTINUOUS_STATES(EventIndicators)
EXPORT(status, fmi3GetNumberOfContinuousStates)(UNUSED void *c, size_t *count)
{
    *count = 0;
    return OK;
}
EXPORT(status, fmi3GetNumberOfEventIndicators)(UNUSED void *c, size_t *count)
{
    *count = 0;
    return OK;
}
EXPORT(status, fmi3ActivateModelPartition)(void *c, UNUSED uint32_t clock, UNUSED double when)
{
    return not_offered(c, "scheduled execution");
}
