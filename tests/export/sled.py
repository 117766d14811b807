"""A small program with the ports of a platform: a sled that follows the force wanted along x, or brakes.

Every period, speed += 0.01 a and place += 0.01 speed, where a is the force along x plus the rate about z; a
request that is not finite halves the speed instead. The acceleration of heave is the force along z. Its
legs are told 1 m plus their place in the pose, and do not reach beyond 0.5 m.
"""

from otolith.core.frames import AXES
from otolith.export.program import Port, Program

_HEADER = """\
#ifndef SLED_H
#define SLED_H
#ifdef __cplusplus
extern "C" {
#endif
typedef struct sled { double speed, place; } sled;
void sled_init(sled *me);
int sled_step(sled *me, const double in[], double out[]);
#ifdef __cplusplus
}
#endif
#ifdef SLED_IMPLEMENTATION
void sled_init(sled *me) { me->speed = me->place = 0.0; }
int sled_step(sled *me, const double in[], double out[])
{
    const double a = in[0] + in[5];
    const int well = a - a == 0.0;
    me->speed = well ? me->speed + 0.01 * a : 0.5 * me->speed;
    me->place += 0.01 * me->speed;
    for (int i = 0; i < 18; i++) out[i] = 0.0;
    out[0] = me->place;
    out[3] = 0.1; out[4] = 0.2; out[5] = 0.3;
    out[6] = me->speed;
    out[12] = well ? a : 0.0;
    out[14] = well ? in[2] : 0.0;
    return well ? 0 : 3;
}
#endif
#endif
"""

_LEGS = """\
#ifndef SLED_LEGS_H
#define SLED_LEGS_H
#ifdef __cplusplus
extern "C" {
#endif
typedef struct sled_legs { int nothing; } sled_legs;
void sled_legs_init(sled_legs *me);
int sled_legs_step(sled_legs *me, const double in[], double out[]);
#ifdef __cplusplus
}
#endif
#ifdef SLED_LEGS_IMPLEMENTATION
void sled_legs_init(sled_legs *me) { me->nothing = 0; }
int sled_legs_step(sled_legs *me, const double in[], double out[])
{
    for (int i = 0; i < 6; i++) out[i] = in[0] > 0.5 ? 0.0 / (in[0] - in[0]) : 1.0 + in[i];
    return me->nothing;
}
#endif
#endif
"""

SLED = Program(
    name="sled",
    period=0.01,
    inputs=tuple(
        Port(f"wanted_{kind}_{axis}", unit, f"{kind} wanted along {axis}")
        for kind, unit in (("force", "m/s2"), ("rate", "rad/s"))
        for axis in "xyz"
    ),
    outputs=tuple(
        Port(f"{kind}_{axis}", ("m" if i < 3 else "rad") + per, f"{kind} of {axis}")
        for kind, per in (("pose", ""), ("velocity", "/s"), ("acceleration", "/s2"))
        for i, axis in enumerate(AXES)
    ),
    header=_HEADER,
)
SLED_LEGS = Program(
    name="sled_legs",
    period=0.01,
    inputs=SLED.outputs[:6],
    outputs=tuple(Port(f"leg_{i + 1}", "m", f"length of leg {i + 1}") for i in range(6)),
    header=_LEGS,
)
