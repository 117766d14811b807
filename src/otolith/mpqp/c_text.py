"""The text of exported laws: templates of the header and of the source, filled in by `export_c`.

The C functions are those of `lookup` and `dualqp`, by the same names where they do the same.
"""

from string import Template
from typing import Final

HEADER: Final = Template("""\
/* Explicit solution of a parametric QP: $regions regions of radius >= $tolerance.
   Model $digest. Written by otolith; C99, no dependencies, no allocation, reentrant.

   No call does more than this, whatever theta and start are: it looks at $steps regions with at most
   $most facets each, then changes the active set of a QP with $m rows and $nv variables at most
   $changes times, together at most $operations multiplications. */
#ifndef ${NAME}_H
#define ${NAME}_H

#define ${NAME}_PARAMETERS $p
#define ${NAME}_OUTPUTS $n
#define ${NAME}_REGIONS $regions
#define ${NAME}_NONE (-1)     /* theta is outside its box, or no z satisfies the constraints */
#define ${NAME}_UNSOLVED (-2) /* the QP did not end within its changes; has not been seen */

/* Minimiser at theta. Returns the region, from which the next search may start; or ${NAME}_REGIONS when z is
   right although theta lies in none of them, but between two; or a negative number, and z is untouched.
   start: what the last call returned, or any number that is no region; the QP is then solved at once. */
int ${name}_evaluate(const double theta[${NAME}_PARAMETERS], int start, double z[${NAME}_OUTPUTS]);

#endif
""")

SOURCE: Final = Template("""\
#include "$name.h"
#include <stdint.h>

enum {
    P = $p, N = $n, STORED = $h, ALONE = $alone, DOMAIN = $domain, STEPS = $steps, /* regions in a walk */
    M = $m, NV = $nv, ROOM = NV + 2, WORDS = $words, SLOTS = $slots, SYMMETRIC = $symmetric,
    CHANGES = $changes, INFEASIBLE = -1, FAILED = -2
};
static const double TOLERANCE = 1e-13; /* of a half-space; where no region is that near, the QP decides */
static const double DEPENDENT = $dependent, TIED = $tied, TIGHT = $tight, LOOSEST = $loosest;

$tables
/* Largest violation among rows first..last-1 of a table of (P + 1) columns; its row in *worst. The processor
   overlaps the two sums. */
static double violation(const double *table, int first, int last, const double *tau, int *worst)
{
    double most = -1e300;
    for (int f = first; f < last; f++) {
        const double *row = table + (long)f * (P + 1);
        double v = -row[P], other = 0.0;
        for (int c = 0; c + 1 < P; c += 2) { v += row[c] * tau[c]; other += row[c + 1] * tau[c + 1]; }
        if (P % 2) v += row[P - 1] * tau[P - 1];
        v += other;
        if (v > most) { most = v; *worst = f; }
    }
    return most;
}
static int stored(int region) { return region < STORED ? region : region - (STORED - ALONE); }

static int twin(int region)
{
    if (region < ALONE) return region;
    return region < STORED ? region + STORED - ALONE : region - (STORED - ALONE);
}

/* The region that contains tau, by crossing the most violated facet again and again; -1 if it is not met. */
static int walk(const double *tau, int region)
{
    for (int i = 0; i < STEPS && region >= 0; i++) {
        int worst = 0, s = stored(region), image = region >= STORED;
        double own[P];
        for (int c = 0; c < P; c++) own[c] = image ? -tau[c] : tau[c];
        if (violation(rows, start[s], start[s + 1], own, &worst) <= TOLERANCE) return region;
        region = beyond[worst] < 0 || !image ? beyond[worst] : twin(beyond[worst]);
    }
    return -1;
}

/* The QP min |u|^2 / 2, M u <= d(tau), by the dual method of Goldfarb and Idnani (1983). a[0..k-1] are the
   active rows, lam their multipliers; L D L' = Q[a][a], with a unit diagonal in L and 1 / D in inverse. */
struct qp {
    int a[ROOM], changes;
    double lam[ROOM], x[ROOM], inverse[ROOM], L[ROOM][ROOM], right[M + 1], slack[M + 1];
};

static double q(int i, int j) { return gram[(long)i * M + j]; }

/* Writes row k of L for constraint j, whose products with the active rows are D L[k]; returns its D. */
static double factor_row(struct qp *w, int k, int j)
{
    double room = q(j, j), *own = w->L[k];
    for (int c = 0; c < k; c++) {
        own[c] = q(w->a[c], j);
        for (int e = 0; e < c; e++) own[c] -= own[e] * w->L[c][e];
    }
    for (int c = 0; c < k; c++) {
        double s = own[c] * w->inverse[c];
        room -= s * own[c];
        own[c] = s;
    }
    return room;
}

static int factor(struct qp *w, int first, int k)
{
    for (int a = first; a < k; a++) {
        double room = factor_row(w, a, w->a[a]);
        if (room < DEPENDENT) return 0;
        w->inverse[a] = 1.0 / room;
    }
    return 1;
}

/* Solves L' x = x. */
static void back_substitute(const struct qp *w, int k, double *x)
{
    for (int a = k - 1; a >= 0; a--)
        for (int e = a + 1; e < k; e++) x[a] -= w->L[e][a] * x[e];
}

/* Solves L D L' x = x. */
static void substitute(const struct qp *w, int k, double *x)
{
    for (int a = 0; a < k; a++)
        for (int e = 0; e < a; e++) x[a] -= w->L[a][e] * x[e];
    for (int a = 0; a < k; a++) x[a] *= w->inverse[a];
    back_substitute(w, k, x);
}

static void slack_of(struct qp *w, int k)
{
    for (int i = 0; i < M; i++) w->slack[i] = w->right[i];
    for (int a = 0; a < k; a++) {
        const double *row = gram + (long)w->a[a] * M;
        for (int i = 0; i < M; i++) w->slack[i] += w->lam[a] * row[i];
    }
}

/* The inactive row with the least slack below -tolerance, or -1. */
static int most_violated(struct qp *w, int k, double tolerance)
{
    int chosen = -1;
    double worst = -tolerance;
    for (int a = 0; a < k; a++) w->slack[w->a[a]] = 0.0;
    for (int i = 0; i < M; i++)
        if (w->slack[i] < worst) { chosen = i; worst = w->slack[i]; }
    return chosen;
}

/* Makes row j, violated by gap, active and drops rows whose multiplier would become negative. Returns the
   number of active rows, or INFEASIBLE when nothing satisfies row j together with the others. */
static int take_in(struct qp *w, int k, int j, double gap)
{
    double own = 0.0;
    for (;;) {
        double room = factor_row(w, k, j), t = 1e300;
        int blocking = -1;
        for (int a = 0; a < k; a++) w->x[a] = w->L[k][a];
        back_substitute(w, k, w->x);
        for (int a = 0; a < k; a++)
            if (w->x[a] > 1e-11 && w->lam[a] < t * w->x[a]) { blocking = a; t = w->lam[a] / w->x[a]; }
        double full = room > DEPENDENT && k < NV ? gap / room : 1e300;
        if (blocking < 0 && full > 1e299) return INFEASIBLE;
        if (full < t) t = full;
        for (int a = 0; a < k; a++) w->lam[a] -= t * w->x[a];
        own += t;
        gap -= t * room;
        if (full <= t) {
            w->a[k] = j;
            w->lam[k] = own;
            w->inverse[k] = 1.0 / room;
            return k + 1;
        }
        for (int a = blocking; a < k - 1; a++) { w->a[a] = w->a[a + 1]; w->lam[a] = w->lam[a + 1]; }
        k--;
        factor(w, blocking, k);
    }
}

static int attempt(struct qp *w, double tolerance)
{
    for (int k = 0; w->changes < CHANGES; w->changes++) {
        slack_of(w, k);
        int j = most_violated(w, k, tolerance);
        if (j < 0) return k;
        double gap = -w->slack[j];
        k = take_in(w, k, j, gap);
        if (k < 0) return gap > LOOSEST ? INFEASIBLE : FAILED;
    }
    return FAILED;
}

/* Number of active rows at the minimum, or INFEASIBLE or FAILED. */
static int solve(struct qp *w)
{
    int k = FAILED;
    for (double tolerance = TIGHT; k == FAILED && tolerance <= LOOSEST; tolerance *= 30.0)
        k = attempt(w, tolerance);
    return k;
}

/* A row with slack zero that depends on the active ones and excludes this set when every bound is relaxed a
   little; -1 when there is none. w->x is set to its coefficients. */
static int tie(struct qp *w, int k)
{
    for (int i = 0; i < M; i++) {
        if (w->slack[i] > TIED || w->slack[i] < -TIED) continue;
        double room = q(i, i), shift = delta[i];
        for (int a = 0; a < k; a++) w->x[a] = q(w->a[a], i);
        substitute(w, k, w->x);
        for (int a = 0; a < k; a++) {
            room -= w->x[a] * q(w->a[a], i);
            shift -= w->x[a] * delta[w->a[a]];
        }
        if (room < DEPENDENT && shift < 0.0) return i;
    }
    return -1;
}

/* Of several active sets with the same minimiser, takes the one that the table holds. */
static void untie(struct qp *w, int k)
{
    for (int turn = 0; turn < 4 * k && factor(w, 0, k); turn++) {
        for (int a = 0; a < k; a++) w->lam[a] = -w->right[w->a[a]];
        substitute(w, k, w->lam);
        slack_of(w, k);
        for (int a = 0; a < k; a++) w->slack[w->a[a]] = 1.0;
        int leave = -1, i = tie(w, k);
        double t = 1e300;
        for (int a = 0; i >= 0 && a < k; a++)
            if (w->x[a] > 1e-9 && w->lam[a] < t * w->x[a]) { leave = a; t = w->lam[a] / w->x[a]; }
        if (leave < 0) return;
        w->a[leave] = i;
    }
}

/* The region of the active rows, or 2 STORED - ALONE when they have none. */
static int region_of(const int *a, int k)
{
    uint64_t key[WORDS] = {0}, other[WORDS] = {0}, *least = key, h = 0;
    for (int i = 0; i < k; i++) {
        key[a[i] / 64] |= (uint64_t)1 << a[i] % 64;
        if (SYMMETRIC) other[mirror[a[i]] / 64] |= (uint64_t)1 << mirror[a[i]] % 64;
    }
    for (int w = 0; SYMMETRIC && w < WORDS; w++)
        if (key[w] != other[w]) {
            least = other[w] < key[w] ? other : key;
            break;
        }
    for (int w = 0; w < WORDS; w++) {
        h = (h ^ least[w]) * UINT64_C(0x9E3779B97F4A7C15);
        h ^= h >> 29;
    }
    for (int s = (int)(h & (SLOTS - 1)); slots[s] >= 0; s = (s + 1) & (SLOTS - 1)) {
        int same = 1;
        for (int w = 0; w < WORDS; w++) same &= keys[(long)slots[s] * WORDS + w] == least[w];
        if (same) return least == key ? slots[s] : twin(slots[s]);
    }
    return 2 * STORED - ALONE;
}

static int by_qp(const double *tau, double *z)
{
    struct qp w;
    w.changes = 0;
    for (int i = 0; i < M; i++) {
        w.right[i] = distance[(long)i * (P + 1) + P];
        for (int c = 0; c < P; c++) w.right[i] += tau[c] * distance[(long)i * (P + 1) + c];
    }
    int k = solve(&w);
    if (k < 0) return k == INFEASIBLE ? ${NAME}_NONE : ${NAME}_UNSOLVED;
    untie(&w, k);
    for (int i = 0; i < N; i++) {
        z[i] = unconstrained[i * (P + 1) + P];
        for (int c = 0; c < P; c++) z[i] += tau[c] * unconstrained[i * (P + 1) + c];
        for (int a = 0; a < k; a++) z[i] -= w.lam[a] * slopes[(long)w.a[a] * N + i];
    }
    return region_of(w.a, k);
}

int ${name}_evaluate(const double theta[P], int from, double z[N])
{
    double tau[P];
    int worst = 0;
    for (int c = 0; c < P; c++) {
        tau[c] = (theta[c] - centre[c]) / half[c];
        if (!(tau[c] >= -1.0 - 1e-8 && tau[c] <= 1.0 + 1e-8)) return ${NAME}_NONE;
    }
    if (DOMAIN > 0 && violation(domain, 0, DOMAIN, tau, &worst) > 1e-8) return ${NAME}_NONE;
    int region = from >= 0 && from < 2 * STORED - ALONE ? walk(tau, from) : -1;
    if (region < 0) return by_qp(tau, z);
    for (int i = 0; i < N; i++) {
        const double *gain = gains + ((long)stored(region) * N + i) * (P + 1);
        double own = unconstrained[i * (P + 1) + P];
        double v = region < STORED ? gain[P] : 2.0 * own - gain[P]; /* odd about the centre */
        for (int c = 0; c < P; c++) v += gain[c] * tau[c];
        z[i] = v;
    }
    return region;
}
""")
