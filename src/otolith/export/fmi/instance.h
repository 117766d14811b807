/* One instance of the exported program inside a co-simulation: its ports, its clock and its messages.

   The program decides once per period. The host may communicate at any other step: a longer one contains several
   periods, a shorter one a part of one. A period reads the inputs that were set last before it begins. Its outputs
   are shown when it ends, since they belong to that moment; where SHOWN_AT_ONCE is 1 (commands, which another model
   shall follow as soon as possible) they are shown at the end of the communication step in which it begins. */
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "model.h"

/* How a function of the interface is declared. */
#define PASTE(prefix, name) prefix##name
#define PREFIXED(prefix, name) PASTE(prefix, name)
#ifdef FUNCTION_PREFIX
#define NAMED(name) PREFIXED(FUNCTION_PREFIX, name)
#else
#define NAMED(name) name
#endif
#if defined _WIN32
#define EXPORT(type, name) __declspec(dllexport) type NAMED(name)
#elif defined __GNUC__
#define EXPORT(type, name) __attribute__((visibility("default"))) type NAMED(name)
#else
#define EXPORT(type, name) type NAMED(name)
#endif
#ifdef __GNUC__
#define UNUSED __attribute__((unused))
#else
#define UNUSED
#endif

#define SLACK (1e-3 * PERIOD)   /* [s] how far a host's sum of steps may be from the sum of periods */
#define LONGEST (1e6 * PERIOD) /* [s] communication step: more would not come back for minutes */
#define LATEST (1e9 * PERIOD)  /* [s] time from 0: later, the rounding of times would come near SLACK */

enum phase { INSTANTIATED, INITIALISING, STEPPING, TERMINATED };
enum severity { WARNED, FAILED };

struct memory { /* all that a stored state of the FMU holds */
    enum phase phase;
    program_state program;
    double start, reached; /* [s] where the first period begins; where the last communication step ended */
    long long ended;       /* periods that have ended */
    int begun;             /* the next period has begun: its outputs are in `next` */
    int status;            /* what the program returned last; 0 when all is well */
    double in[INPUTS], out[OUTPUTS], next[OUTPUTS];
};

struct instance {
    struct memory now;
    void (*tell)(const struct instance *me, enum severity severity, const char *sentence);
    void *environment, *callback; /* the host's own, handed back to it with every message */
    int chatty;                   /* the host wants warnings, too */
    char name[256];
};

static int fail(const struct instance *me, const char *format, ...)
{
    char sentence[400];
    va_list values;
    va_start(values, format);
    vsnprintf(sentence, sizeof sentence, format, values);
    va_end(values);
    me->tell(me, FAILED, sentence);
    return 0;
}

static void begin_anew(struct memory *now)
{
    memset(now, 0, sizeof *now);
    program_init(&now->program);
    memcpy(now->in, input_start, sizeof now->in);
    memcpy(now->out, output_start, sizeof now->out);
}

/* Makes an instance, or returns NULL where the description is another program's or memory is lacking. */
static struct instance *make(const char *name, const char *token)
{
    struct instance *me;
    if (token == NULL || strcmp(token, TOKEN) != 0) return NULL;
    me = calloc(1, sizeof *me);
    if (me == NULL) return NULL;
    snprintf(me->name, sizeof me->name, "%s", name == NULL ? "" : name);
    begin_anew(&me->now);
    return me;
}

/* Goes from one phase to another; 0 and a message when the instance is in none from which this is allowed. */
static int enter(struct instance *me, enum phase from, enum phase to, const char *what)
{
    static const char *const names[] = {"instantiated", "in initialization", "in step mode", "terminated"};
    if (me->now.phase != from)
        return fail(me, "%s was called while the instance is %s, must be %s", what, names[me->now.phase], names[from]);
    me->now.phase = to;
    return 1;
}

static int begin_at(struct instance *me, double start)
{
    if (!(fabs(start) <= LATEST))
        return fail(me, "the start time is %g s, must be within %g s of 0", start, LATEST);
    me->now.start = me->now.reached = start;
    return 1;
}

/* The place of a value, by its reference: 0 is the time, then come all inputs, then all outputs. */
static const double *place(const struct instance *me, unsigned reference)
{
    if (reference == 0) return &me->now.reached;
    if (reference <= INPUTS) return &me->now.in[reference - 1];
    if (reference <= INPUTS + OUTPUTS) return &me->now.out[reference - INPUTS - 1];
    fail(me, "value reference %u is unknown, must be at most %d", reference, INPUTS + OUTPUTS);
    return NULL;
}

static int get(const struct instance *me, const unsigned references[], size_t count, double values[])
{
    for (size_t i = 0; i < count; i++) {
        const double *value = place(me, references[i]);
        if (value == NULL) return 0;
        values[i] = *value;
    }
    return 1;
}

static int set(struct instance *me, const unsigned references[], size_t count, const double values[])
{
    for (size_t i = 0; i < count; i++)
        if (references[i] < 1 || references[i] > INPUTS)
            return fail(me, "value reference %u was set, must be an input's, 1 to %d", references[i], INPUTS);
    for (size_t i = 0; i < count; i++) me->now.in[references[i] - 1] = values[i];
    return 1;
}

/* Decides once; a fallback is told when it changes, not once per period. */
static int decide(struct instance *me)
{
    struct memory *now = &me->now;
    char sentence[200];
    int status = program_step(&now->program, now->in, now->next);
    if (status < 0) return fail(me, "a model in the program has no answer at %g s", now->reached);
    for (int i = 0; i < OUTPUTS; i++) {
        if (isfinite(now->next[i])) continue;
        if (output_has_unit[i]) return fail(me, "output %s is not finite at %g s", output_name[i], now->reached);
        now->next[i] = -1.0; /* a figure of the solver that does not exist; many hosts end where a NaN appears */
    }
    if (status != now->status && status != 0) {
        snprintf(sentence, sizeof sentence, "from %.9g s on a fallback brakes to rest, status %d (%s)", now->reached,
                 status, status > 0 && status < STATUSES ? status_name[status] : "unknown");
        me->tell(me, WARNED, sentence);
    }
    now->status = status;
    now->begun = 1;
    return 1;
}

static int advance(struct instance *me, double from, double length)
{
    struct memory *now = &me->now;
    double to = from + length;
    if (now->phase != STEPPING) return enter(me, STEPPING, STEPPING, "doStep");
    if (!(length >= 0.0 && length <= LONGEST))
        return fail(me, "the communication step is %g s, must be 0 to %g s", length, LONGEST);
    if (!(fabs(to) <= LATEST)) return fail(me, "the time would be %g s, must be within %g s of 0", to, LATEST);
    if (!(fabs(from - now->reached) <= SLACK))
        return fail(me, "the communication step begins at %.17g s, must begin at %.17g s, where the last ended", from,
                    now->reached);
    for (;;) {
        double begin = now->start + (double)now->ended * PERIOD;
        if (!now->begun) {
            if (begin > to - SLACK) break;
            if (!decide(me)) return 0;
            if (SHOWN_AT_ONCE) memcpy(now->out, now->next, sizeof now->out);
        }
        if (begin + PERIOD > to + SLACK) break;
        memcpy(now->out, now->next, sizeof now->out);
        now->begun = 0;
        now->ended++;
    }
    now->reached = to;
    return 1;
}

/* Stored states. Their bytes are for the same binary on the same kind of machine, and begin with its token. */
#define STORED (sizeof(TOKEN) + sizeof(struct memory))

static int store(const struct instance *me, void **state)
{
    if (*state == NULL) *state = malloc(sizeof me->now);
    if (*state == NULL) return fail(me, "no memory for a state of %lu bytes", (unsigned long)sizeof me->now);
    memcpy(*state, &me->now, sizeof me->now);
    return 1;
}

static int restore(struct instance *me, const void *state)
{
    if (state == NULL) return fail(me, "the state to go back to is NULL, must be one that this FMU gave");
    memcpy(&me->now, state, sizeof me->now);
    return 1;
}

static int write_state(const struct instance *me, const void *state, void *bytes, size_t size)
{
    if (state == NULL || size < STORED) return fail(me, "a state needs %lu bytes", (unsigned long)STORED);
    memcpy(bytes, TOKEN, sizeof(TOKEN));
    memcpy((char *)bytes + sizeof(TOKEN), state, sizeof(struct memory));
    return 1;
}

static int read_state(const struct instance *me, const void *bytes, size_t size, void **state)
{
    if (size < STORED || memcmp(bytes, TOKEN, sizeof(TOKEN)) != 0)
        return fail(me, "the stored state was written by another FMU");
    if (*state == NULL) *state = malloc(sizeof me->now);
    if (*state == NULL) return fail(me, "no memory for a state of %lu bytes", (unsigned long)sizeof me->now);
    memcpy(*state, (const char *)bytes + sizeof(TOKEN), sizeof me->now);
    return 1;
}
