/* Ambient visibility in a pack is kept in few bits: what the eye cannot tell apart is not worth its bytes (docs/codecs.md). */
#ifndef SCREE_OCCLUSION_H
#define SCREE_OCCLUSION_H

#include <stdint.h>

#define OCCLUSION_BITS 4
#define OCCLUSION_MAX ((1u << OCCLUSION_BITS) - 1)

/* 0..255 to the nearest of the levels a pack keeps, 0..OCCLUSION_MAX. */
static inline uint8_t occlusion_level(uint8_t value) {
  return (uint8_t)((value * OCCLUSION_MAX + 127) / 255);
}

/* A level back to 0..255; levels out of range are clamped. */
static inline uint8_t occlusion_value(int level) {
  const unsigned clamped = level < 0 ? 0 : level > (int)OCCLUSION_MAX ? OCCLUSION_MAX : (unsigned)level;
  return (uint8_t)((clamped * 255 + OCCLUSION_MAX / 2) / OCCLUSION_MAX);
}

#endif
