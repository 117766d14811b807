/* FMI 2.0 for Co-Simulation around one exported program. What the standard declares is declared here in our own
   words, so that this folder compiles without other files. Where several FMUs are linked into one program,
   -DFUNCTION_PREFIX=name_ tells their functions apart. */
#include "instance.h"

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING } status;
typedef enum { MODEL_EXCHANGE, CO_SIMULATION } kind;
typedef enum { DO_STEP_STATUS, PENDING_STATUS, LAST_SUCCESSFUL_TIME, IS_TERMINATED } question;
typedef void (*logger)(void *environment, const char *name, status how, const char *category, const char *text, ...);
typedef struct {
    logger log;
    void *(*allocate)(size_t count, size_t size);
    void (*release)(void *memory);
    void (*finished)(void *environment, status how);
    void *environment;
} callbacks;

static status said(int well) { return well ? OK : ERROR; }

static void tell(const struct instance *me, enum severity severity, const char *sentence)
{
    const callbacks *host = me->callback;
    if (host->log == NULL || (severity == WARNED && !me->chatty)) return;
    host->log(me->environment, me->name, severity == FAILED ? ERROR : WARNING,
              severity == FAILED ? "logStatusError" : "logStatusWarning", "%s", sentence);
}

EXPORT(const char *, fmi2GetTypesPlatform)(void) { return "default"; }
EXPORT(const char *, fmi2GetVersion)(void) { return "2.0"; }

EXPORT(status, fmi2SetDebugLogging)(void *c, int on, UNUSED size_t count, UNUSED const char *const categories[])
{
    ((struct instance *)c)->chatty = on;
    return OK;
}

EXPORT(void *, fmi2Instantiate)(const char *name, kind what, const char *guid, UNUSED const char *resources,
                                const callbacks *host, UNUSED int visible, int logging)
{
    struct instance *me = what == CO_SIMULATION && host != NULL ? make(name, guid) : NULL;
    if (me == NULL) {
        if (host != NULL && host->log != NULL)
            host->log(host->environment, name, ERROR, "logStatusError", "%s",
                      "the instance could not be made: co-simulation with the GUID of this FMU's own description "
                      "is offered");
        return NULL;
    }
    me->callback = (void *)host;
    me->environment = host->environment;
    me->tell = tell;
    me->chatty = logging;
    return me;
}

EXPORT(void, fmi2FreeInstance)(void *c) { free(c); }

EXPORT(status, fmi2SetupExperiment)(void *c, UNUSED int tolerant, UNUSED double tolerance, double start,
                                    UNUSED int ends, UNUSED double stop)
{
    return said(enter(c, INSTANTIATED, INSTANTIATED, "fmi2SetupExperiment") && begin_at(c, start));
}
EXPORT(status, fmi2EnterInitializationMode)(void *c)
{
    return said(enter(c, INSTANTIATED, INITIALISING, "fmi2EnterInitializationMode"));
}
EXPORT(status, fmi2ExitInitializationMode)(void *c)
{
    return said(enter(c, INITIALISING, STEPPING, "fmi2ExitInitializationMode"));
}
EXPORT(status, fmi2Terminate)(void *c) { return said(enter(c, STEPPING, TERMINATED, "fmi2Terminate")); }
EXPORT(status, fmi2Reset)(void *c)
{
    begin_anew(&((struct instance *)c)->now);
    return OK;
}

EXPORT(status, fmi2GetReal)(void *c, const unsigned vr[], size_t n, double values[])
{
    return said(get(c, vr, n, values));
}
EXPORT(status, fmi2SetReal)(void *c, const unsigned vr[], size_t n, const double values[])
{
    return said(set(c, vr, n, values));
}

/* There are variables of no other type: asking for none is well. */
static status none(const struct instance *me, size_t n, const char *type)
{
    return said(n == 0 || fail(me, "a variable of type %s was asked for, and this FMU has none", type));
}
#define NO_VARIABLES(name, type) \
    EXPORT(status, fmi2Get##name)(void *c, UNUSED const unsigned vr[], size_t n, UNUSED type values[]) \
    { \
        return none(c, n, #name); \
    } \
    EXPORT(status, fmi2Set##name)(void *c, UNUSED const unsigned vr[], size_t n, UNUSED const type values[]) \
    { \
        return none(c, n, #name); \
    }
typedef const char *string;
NO_VARIABLES(Integer, int)
NO_VARIABLES(Boolean, int)
NO_VARIABLES(String, string)

EXPORT(status, fmi2GetFMUstate)(void *c, void **state) { return said(store(c, state)); }
EXPORT(status, fmi2SetFMUstate)(void *c, void *state) { return said(restore(c, state)); }
EXPORT(status, fmi2FreeFMUstate)(UNUSED void *c, void **state)
{
    free(*state);
    *state = NULL;
    return OK;
}
EXPORT(status, fmi2SerializedFMUstateSize)(UNUSED void *c, UNUSED void *state, size_t *size)
{
    *size = STORED;
    return OK;
}
EXPORT(status, fmi2SerializeFMUstate)(void *c, void *state, char bytes[], size_t size)
{
    return said(write_state(c, state, bytes, size));
}
EXPORT(status, fmi2DeSerializeFMUstate)(void *c, const char bytes[], size_t size, void **state)
{
    return said(read_state(c, bytes, size, state));
}

/* Not offered, as the description says; a host that calls them all the same gets an error and a sentence. */
EXPORT(status, fmi2GetDirectionalDerivative)(void *c, UNUSED const unsigned unknown[], UNUSED size_t unknowns,
                                             UNUSED const unsigned known[], UNUSED size_t knowns,
                                             UNUSED const double seed[], UNUSED double derivative[])
{
    return said(fail(c, "directional derivatives are not offered"));
}
EXPORT(status, fmi2SetRealInputDerivatives)(void *c, UNUSED const unsigned vr[], size_t n, UNUSED const int order[],
                                            UNUSED const double values[])
{
    return said(n == 0 || fail(c, "inputs are held, so their derivatives are not taken"));
}
EXPORT(status, fmi2GetRealOutputDerivatives)(void *c, UNUSED const unsigned vr[], size_t n, UNUSED const int order[],
                                             UNUSED double values[])
{
    return said(n == 0 || fail(c, "derivatives of outputs are not offered"));
}

EXPORT(status, fmi2DoStep)(void *c, double from, double length, UNUSED int no_way_back)
{
    return said(advance(c, from, length));
}
EXPORT(status, fmi2CancelStep)(void *c) { return said(fail(c, "no step is pending: each is done when doStep returns")); }

/* Steps are done when they return: nothing is ever pending. */
EXPORT(status, fmi2GetStatus)(void *c, UNUSED question what, UNUSED status *value)
{
    fail(c, "no step is pending");
    return DISCARD;
}
EXPORT(status, fmi2GetRealStatus)(void *c, question what, double *value)
{
    if (what != LAST_SUCCESSFUL_TIME) return DISCARD;
    *value = ((struct instance *)c)->now.reached;
    return OK;
}
EXPORT(status, fmi2GetIntegerStatus)(UNUSED void *c, UNUSED question what, UNUSED int *value) { return DISCARD; }
EXPORT(status, fmi2GetBooleanStatus)(UNUSED void *c, question what, int *value)
{
    if (what != IS_TERMINATED) return DISCARD;
    *value = 0; /* the FMU never ends a simulation of its own accord */
    return OK;
}
EXPORT(status, fmi2GetStringStatus)(UNUSED void *c, UNUSED question what, UNUSED const char **value)
{
    return DISCARD;
}
