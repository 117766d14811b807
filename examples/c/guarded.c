/* A chain in C: an algorithm decides every 10 ms; every millisecond the gate moves the set-point under its command, and
   the supervisor passes on what six legs can do of it.

       otolith export c --cueing classical --platform davsi --out examples/c/cueing
       otolith export c --kind gate --platform davsi --name gate --out examples/c/gate
       otolith export c --kind supervisor --platform davsi --name supervisor --out examples/c/supervisor
       cd examples/c && cc -std=c99 -O2 -ffp-contract=off -I cueing -I gate -I supervisor guarded.c cueing/cueing.c \
           gate/gate.c supervisor/supervisor.c -lm -o guarded && ./guarded

   A washout knows no limits, and is asked for more than the machine can give. What it is told of the platform is the
   set-point, as in live operation; a host that measures hands over what it measures. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cueing.h"
#include "gate.h"
#include "supervisor.h"

enum { WANTED_FORCE_X = 0, MEASURED = 6, MOTION = 18, REFUSAL = 18, LEG_RATES = 6, REASON = 12 };

static cueing algorithm;
static gate guard;
static supervisor legs;

int main(void) {
    double in[CUEING_INPUTS] = {0}, command[CUEING_OUTPUTS] = {0}, set[GATE_OUTPUTS] = {0}, passed[SUPERVISOR_OUTPUTS];
    const int each = (int)(CUEING_PERIOD / GATE_PERIOD + 0.5);
    int refused = 0, slowed = 0;
    double farthest = 0.0, fastest = 0.0;
    cueing_init(&algorithm);
    gate_init(&guard);
    supervisor_init(&legs);
    for (int k = 0; k * GATE_PERIOD < 10.0; k++) {
        if (k % each == 0) {
            in[WANTED_FORCE_X] = 6.0 * sin(2.0 * k * GATE_PERIOD); /* [m/s2] */
            memcpy(in + MEASURED, set, MOTION * sizeof(double));
            cueing_step(&algorithm, in, command);
        }
        refused += gate_step(&guard, command, set) != 0;     /* the first six outputs are its command */
        slowed += supervisor_step(&legs, set, passed) != 0; /* the first twelve are pose and velocity */
        farthest = fmax(farthest, fabs(set[0]));
        fastest = fmax(fastest, fabs(passed[LEG_RATES]));
    }
    printf("10 s: surge up to %.3f m; the gate refused %d set-points, the legs were slowed in %d; leg 1 up to %.3f m/s\n",
           farthest, refused, slowed, fastest);
    return 0;
}
