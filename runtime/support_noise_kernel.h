/* Gradient noise, as static functions: included by support_kernel.h.
 * Based on: Perlin, Improving Noise, 2002, for the twelve gradients; the lattice is hashed, without a table, and the fade is the
 * cubic one, which is less steep.
 *
 * The largest value and slope of one octave, over all points and all choices of gradients, are 1.04492 and 3 (found by search: for
 * one point and direction each corner's best gradient is known). */
#ifndef SCREE_SUPPORT_NOISE_KERNEL_H
#define SCREE_SUPPORT_NOISE_KERNEL_H

#include "support_vectors.h"

static inline vuint noise_hash(vuint h) {
  h ^= h >> 16;
  h *= (vuint)v_set_int(0x7feb352d);
  h ^= h >> 15;
  h *= (vuint)v_set_int((int32_t)0x846ca68bu);
  return h ^ h >> 16;
}

/* The gradient of a corner, one of the midpoints of a cube's edges, times the way from there. */
static inline vfloat noise_corner(vuint hash, vfloat x, vfloat y, vfloat z) {
  vint h = (vint)(hash >> 28);
  vfloat u = v_select(h < v_set_int(8), x, y);
  vfloat v = v_select(h < v_set_int(4), y, v_select((h & v_set_int(13)) == v_set_int(12), x, z));
  u = (vfloat)((vuint)u ^ (vuint)h << 31);
  v = (vfloat)((vuint)v ^ (vuint)(h >> 1) << 31);
  return u + v;
}

static inline vfloat noise_fade(vfloat t) {
  return t * t * (v_set(3) - (t + t));
}

/* One octave times `height`; the point is in its wavelengths. */
static inline vfloat noise_octave(vfloat x, vfloat y, vfloat z, uint32_t seed, float height) {
  /* Beyond this there are no fractions left, and int32 has its end. */
  const vfloat far = v_set(1e9f), one = v_set(1);
  const vfloat fx = v_floor(v_clamp(x, -far, far)), fy = v_floor(v_clamp(y, -far, far)), fz = v_floor(v_clamp(z, -far, far));
  const vuint ix = (vuint)v_truncate(fx), iy = (vuint)v_truncate(fy), iz = (vuint)v_truncate(fz);
  x = v_clamp(x - fx, v_set(0), one);
  y = v_clamp(y - fy, v_set(0), one);
  z = v_clamp(z - fz, v_set(0), one);
  const vfloat u = noise_fade(x), v = noise_fade(y), w = noise_fade(z);
  vfloat plane[2];
  for (int k = 0; k < 2; ++k) {
    vfloat line[2];
    vuint deep = noise_hash((iz + (vuint)v_set_int(k)) ^ (vuint)v_set_int((int32_t)seed));
    for (int j = 0; j < 2; ++j) {
      vuint row = noise_hash((iy + (vuint)v_set_int(j)) ^ deep);
      vfloat dy = y - v_set((float)j), dz = z - v_set((float)k);
      vfloat a = noise_corner(noise_hash(ix ^ row), x, dy, dz);
      vfloat b = noise_corner(noise_hash((ix + (vuint)v_set_int(1)) ^ row), x - one, dy, dz);
      line[j] = a + u * (b - a);
    }
    plane[k] = line[0] + v * (line[1] - line[0]);
  }
  return (plane[0] + w * (plane[1] - plane[0])) * v_set(height);
}

/* What the noise adds to a distance at p. */
static inline vfloat noise_at(const support_op* op, vpoint p) {
  vpoint q = into_frame(&op->noise.frame, p);
  vfloat sum = v_set(0);
  for (uint32_t o = 0; o < op->noise.octaves; ++o) {
    sum += noise_octave(q.x, q.y, q.z, op->noise.seed + o * 0x9e3779b9u, op->noise.heights[o]);
    q = (vpoint){q.x + q.x, q.y + q.y, q.z + q.z};
  }
  return v_clamp(sum, v_set(-op->noise.amplitude), v_set(op->noise.amplitude));
}

/* Bounds of the noise over balls: each octave stays within its height, and within its slope times the radius of what it is in the
 * middle. `margin` is what rounding may do. */
static inline void noise_bounds(const support_op* op, vpoint p, vfloat radius, float margin, vfloat* low, vfloat* high) {
  const vfloat amplitude = v_set(op->noise.amplitude), moves = radius * v_set(op->noise.slope);
  *low = -amplitude;
  *high = amplitude;
  if (v_bits(moves < v_set(op->noise.heights[0])) == 0) return;
  vfloat value = noise_at(op, p), change = v_set(margin);
  for (uint32_t o = 0; o < op->noise.octaves; ++o) change += v_min(moves, v_set(2.1f * op->noise.heights[o]));
  *low = v_max(*low, value - change);
  *high = v_min(*high, value + change);
}

#endif
