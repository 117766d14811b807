/* A host in C: drive a platform with an exported algorithm for three seconds, and print what is felt.

       otolith export c --cueing predictive --kind platform --out examples/c/cueing
       cc -std=c99 -O2 -I examples/c/cueing examples/c/main.c examples/c/cueing/cueing.c -lm -o main && ./main

   The loop below is what a real-time task does once per period, in place of printing: read what the vehicle
   wants, step, send on. */
#include <stdio.h>

#include "cueing.h"

enum { WANTED_FORCE_X = 0, POSE_SURGE = 0, POSE_PITCH = 4, FELT_FORCE_X = 18 }; /* see the list in cueing.h */

static cueing algorithm; /* all memory that there is */

int main(void) {
    double in[CUEING_INPUTS] = {0}, out[CUEING_OUTPUTS];
    cueing_init(&algorithm);
    for (int k = 0; k * CUEING_PERIOD < 3.0; k++) {
        const double time = k * CUEING_PERIOD;
        in[WANTED_FORCE_X] = time < 0.5 || time > 2.5 ? 0.0 : 1.0; /* [m/s2] two seconds of acceleration */
        const int status = cueing_step(&algorithm, in, out);
        if (k % 25 == 0 || status != 0)
            printf("%4.2f s: wanted %4.2f, felt %5.2f m/s2, at %6.3f m and %6.3f rad, status %d\n", time,
                   in[WANTED_FORCE_X], out[FELT_FORCE_X], out[POSE_SURGE], out[POSE_PITCH], status);
    }
    return 0;
}
