/* Sums of doubles as expansions: lists of doubles that do not overlap, smallest first, whose sum is exact.
 * Based on: Shewchuk 1997, "Adaptive precision floating-point arithmetic and fast robust geometric predicates"; here with one
 * filter and then everything at once, since few points come to that. */
#include "orientation.h"

#include <math.h>

enum { MOST_TERMS = 200 }; /* 6 products of three sums of two are 48 of three doubles, 4 terms each */

typedef struct expansion {
  double terms[MOST_TERMS];
  int count;
} expansion;

static double two_sum(double a, double b, double* rest) {
  const double sum = a + b, of_b = sum - a, of_a = sum - of_b;
  *rest = (a - of_a) + (b - of_b);
  return sum;
}

static double two_product(double a, double b, double* rest) {
  const double split = 134217729; /* 2^27 + 1 */
  const double ca = split * a, cb = split * b;
  const double a1 = ca - (ca - a), b1 = cb - (cb - b), a0 = a - a1, b0 = b - b1;
  const double product = a * b;
  *rest = a0 * b0 - (((product - a1 * b1) - a0 * b1) - a1 * b0);
  return product;
}

static void add(expansion* e, double term) {
  if (term == 0) return;
  int count = 0;
  for (int i = 0; i < e->count; ++i) {
    double rest;
    term = two_sum(term, e->terms[i], &rest);
    if (rest != 0) e->terms[count++] = rest;
  }
  if (term != 0) e->terms[count++] = term;
  e->count = count;
}

static int sign_of(double x) {
  return (x > 0) - (x < 0);
}

static int sign_of_sum(const expansion* e) {
  return e->count > 0 ? sign_of(e->terms[e->count - 1]) : 0;
}

/* A difference, exact: its two parts. */
typedef struct difference {
  double parts[2];
} difference;

static difference minus(double a, double b) {
  difference d;
  d.parts[0] = two_sum(a, -b, &d.parts[1]);
  return d;
}

static void add_product(expansion* e, double sign, difference a, difference b) {
  for (int i = 0; i < 2; ++i)
    for (int k = 0; k < 2; ++k) {
      if (a.parts[i] == 0 || b.parts[k] == 0) continue;
      double rest;
      const double product = two_product(sign * a.parts[i], b.parts[k], &rest);
      add(e, rest);
      add(e, product);
    }
}

static void add_triple(expansion* e, double sign, difference a, difference b, difference c) {
  for (int i = 0; i < 8; ++i) {
    const double x = sign * a.parts[i & 1], y = b.parts[i >> 1 & 1], z = c.parts[i >> 2];
    if (x == 0 || y == 0 || z == 0) continue;
    double low, rest;
    const double high = two_product(x, y, &low);
    const double small = two_product(low, z, &rest);
    add(e, rest);
    add(e, small);
    const double large = two_product(high, z, &rest);
    add(e, rest);
    add(e, large);
  }
}

int orientation_exact(const double a[3], const double b[3], const double c[3], const double d[3]) {
  for (int k = 0; k < 3; ++k)
    if (a[k] == b[k] && a[k] == c[k] && a[k] == d[k]) return 0;
  difference u[3], v[3], w[3];
  for (int k = 0; k < 3; ++k) u[k] = minus(b[k], a[k]), v[k] = minus(c[k], a[k]), w[k] = minus(d[k], a[k]);
  expansion e = {.count = 0};
  for (int k = 0; k < 3; ++k) {
    add_triple(&e, 1, u[k], v[(k + 1) % 3], w[(k + 2) % 3]);
    add_triple(&e, -1, u[(k + 1) % 3], v[k], w[(k + 2) % 3]);
  }
  return sign_of_sum(&e);
}

int orientation(const double a[3], const double b[3], const double c[3], const double d[3]) {
  double u[3], v[3], w[3], sum = 0, size = 0;
  for (int k = 0; k < 3; ++k) u[k] = b[k] - a[k], v[k] = c[k] - a[k], w[k] = d[k] - a[k];
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3, m = (k + 2) % 3;
    const double one = u[k] * v[l], other = u[l] * v[k];
    sum += (one - other) * w[m];
    size += (fabs(one) + fabs(other)) * fabs(w[m]);
  }
  /* Each of six terms has eight roundings of 2^-53 at most, their sum a few more. */
  if (fabs(sum) > 2e-15 * size) return sign_of(sum);
  return orientation_exact(a, b, c, d);
}

int orientation_flat(const double a[3], const double b[3], const double c[3], int x, int y) {
  const double one = (a[x] - c[x]) * (b[y] - c[y]), other = (a[y] - c[y]) * (b[x] - c[x]), sum = one - other;
  if (fabs(sum) > 1e-15 * (fabs(one) + fabs(other))) return sign_of(sum);
  expansion e = {.count = 0};
  add_product(&e, 1, minus(a[x], c[x]), minus(b[y], c[y]));
  add_product(&e, -1, minus(a[y], c[y]), minus(b[x], c[x]));
  return sign_of_sum(&e);
}
