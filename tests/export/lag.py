"""A program so small that its answers are known in closed form: y follows u as a lag of first order."""

from otolith.export.program import Port, Program

PERIOD, GAIN = 0.01, 0.1
TROUBLED = 5.0  # above this input the program says that a fallback decides …
BROKEN = 1000.0  # … and above this one that it has no answer

_HEADER = f"""\
#ifndef LAG_H
#define LAG_H
typedef struct lag {{ double y; }} lag;
#define LAG_PERIOD {PERIOD}
#define LAG_INPUTS 1
#define LAG_OUTPUTS 3
void lag_init(lag *me);
int lag_step(lag *me, const double in[], double out[]);
#ifdef LAG_IMPLEMENTATION
void lag_init(lag *me) {{ me->y = 0.0; }}
int lag_step(lag *me, const double in[], double out[])
{{
    me->y += {GAIN} * (in[0] - me->y);
    out[0] = me->y;
    out[1] = in[0];
    out[2] = in[0] > {TROUBLED} ? 1.0 / (in[0] - in[0]) : 0.5;
    return in[0] > {BROKEN} ? -1 : in[0] > {TROUBLED};
}}
#endif
#endif
"""

LAG = Program(
    name="lag",
    period=PERIOD,
    inputs=(Port("u", "m/s2", "what comes in"),),
    outputs=(
        Port("y", "m/s2", "u, lagged"),
        Port("seen", "rad/s", "u, as it was read <here & now>"),
        Port("residual", "", "infinite where a fallback decides"),
    ),
    header=_HEADER,
)
