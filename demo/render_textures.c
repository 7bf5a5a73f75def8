#include "render_textures.h"

#include <epoxy/gl.h>
#include <math.h>
#include <stdlib.h>

static uint32_t mix_bits(uint32_t x) {
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  x ^= x >> 16;
  return x;
}

static uint32_t hash3(int x, int y, int z) {
  return mix_bits((uint32_t)x + mix_bits((uint32_t)y + mix_bits((uint32_t)z + 0x9e3779b9u)));
}

static float unit(uint32_t bits) {
  return (float)(bits >> 8) * (1.0f / 16777216.0f);
}

/* The twelve edges of a cube and four of them again, as Perlin 2002 has it. */
static const float gradients[16][3] = {{1, 1, 0},  {-1, 1, 0},  {1, -1, 0}, {-1, -1, 0}, {1, 0, 1},  {-1, 0, 1},
                                       {1, 0, -1}, {-1, 0, -1}, {0, 1, 1},  {0, -1, 1},  {0, 1, -1}, {0, -1, -1},
                                       {1, 1, 0},  {-1, 1, 0},  {0, -1, 1}, {0, -1, -1}};

/* value and derivative of tileable gradient noise; period in lattice steps */
static void gradient_noise(float x, float y, float z, int period, uint32_t salt, float out[4]) {
  const float p[3] = {x, y, z};
  int base[3];
  float f[3], s[3], d[3];
  for (int a = 0; a < 3; ++a) {
    float down = floorf(p[a]);
    base[a] = (int)down;
    f[a] = p[a] - down;
    s[a] = f[a] * f[a] * f[a] * (f[a] * (f[a] * 6 - 15) + 10);
    d[a] = 30 * f[a] * f[a] * (f[a] * (f[a] - 2) + 1);
  }
  for (int i = 0; i < 4; ++i) out[i] = 0;
  for (int corner = 0; corner < 8; ++corner) {
    float w[3], dw[3], r[3];
    int c[3];
    for (int a = 0; a < 3; ++a) {
      int bit = corner >> a & 1;
      c[a] = (base[a] + bit) % period;
      w[a] = bit ? s[a] : 1 - s[a];
      dw[a] = bit ? d[a] : -d[a];
      r[a] = f[a] - (float)bit;
    }
    const float* g = gradients[(hash3(c[0], c[1], c[2]) + salt * 0x9e3779b9u) >> 7 & 15];
    float dot = g[0] * r[0] + g[1] * r[1] + g[2] * r[2];
    float weight = w[0] * w[1] * w[2];
    out[0] += weight * dot;
    out[1] += weight * g[0] + dw[0] * w[1] * w[2] * dot;
    out[2] += weight * g[1] + w[0] * dw[1] * w[2] * dot;
    out[3] += weight * g[2] + w[0] * w[1] * dw[2] * dot;
  }
}

void render_noise_volume(float* texels) {
  const float step = (float)RENDER_NOISE_PERIOD / RENDER_NOISE_SIZE;
  for (int z = 0; z < RENDER_NOISE_SIZE; ++z)
    for (int y = 0; y < RENDER_NOISE_SIZE; ++y)
      for (int x = 0; x < RENDER_NOISE_SIZE; ++x, texels += 4)
        gradient_noise(((float)x + 0.5f) * step, ((float)y + 0.5f) * step, ((float)z + 0.5f) * step, RENDER_NOISE_PERIOD, 0,
                       texels);
}

/* Distances to the nearest and second nearest of one random point a cell, and a number of the nearest one's own. */
static void nearest_points(float u, float v, int period, uint32_t salt, float* first, float* second, float* own) {
  int bu = (int)floorf(u), bv = (int)floorf(v);
  float best = 9, next = 9;
  *own = 0;
  for (int dv = -1; dv <= 1; ++dv)
    for (int du = -1; du <= 1; ++du) {
      int cu = (bu + du + period) % period, cv = (bv + dv + period) % period;
      uint32_t hash = hash3(cu, cv, (int)salt);
      float x = (float)(bu + du) + unit(hash) - u, y = (float)(bv + dv) + unit(mix_bits(hash + 1)) - v;
      float distance = x * x + y * y;
      if (distance < best) {
        next = best;
        best = distance;
        *own = unit(mix_bits(hash + 2));
      } else if (distance < next) {
        next = distance;
      }
    }
  *first = sqrtf(best);
  *second = sqrtf(next);
}

static float smooth(float low, float high, float x) {
  float t = (x - low) / (high - low);
  t = t < 0 ? 0 : t > 1 ? 1 : t;
  return t * t * (3 - 2 * t);
}

/* Height of the grain at (u, v) in [0, 1)^2, in units of the map's side, and the speckle there. */
static float grain(float u, float v, float* speckle) {
  float n[4], first, second, own, height = 0;
  /* Even roughness, from chips to sand. */
  static const struct {
    int period;
    float depth;
  } octaves[] = {{6, 0.0100f}, {13, 0.0060f}, {29, 0.0030f}, {61, 0.0016f}, {113, 0.0008f}};
  for (unsigned i = 0; i < sizeof octaves / sizeof *octaves; ++i) {
    float period = (float)octaves[i].period;
    gradient_noise(u * period, v * period, 0.37f, octaves[i].period, i + 1, n);
    height += octaves[i].depth * n[0];
  }
  /* Pits, round and of all depths; most places have none. */
  nearest_points(u * 17, v * 17, 17, 71, &first, &second, &own);
  float pit = own > 0.62f ? (1 - smooth(0.05f, 0.16f + 0.30f * (own - 0.62f), first)) * (own - 0.5f) : 0;
  height -= 0.0060f * pit;
  nearest_points(u * 47, v * 47, 47, 72, &first, &second, &own);
  pit = own > 0.55f ? (1 - smooth(0.05f, 0.34f, first)) * (own - 0.4f) : 0;
  height -= 0.0030f * pit;
  /* Hairline cracks: borders between cells, bent by noise, only where a slow noise lets them. */
  gradient_noise(u * 3, v * 3, 0.7f, 3, 81, n);
  float allowed = smooth(-0.05f, 0.30f, n[0]);
  gradient_noise(u * 11, v * 11, 0.2f, 11, 82, n);
  nearest_points(u * 3 + 0.10f * n[0] + 3, v * 3 + 0.03f * n[1] + 3, 3, 83, &first, &second, &own);
  height -= 0.0018f * allowed * (1 - smooth(0.0f, 0.03f, second - first));

  /* Speckles: grains of dark and of bright minerals. */
  nearest_points(u * 89, v * 89, 89, 91, &first, &second, &own);
  float mark = 1 - smooth(0.25f, 0.45f, first);
  *speckle = own < 0.22f ? -mark * (0.5f + 2.2f * own) : own > 0.90f ? mark * 0.8f : 0;
  gradient_noise(u * 41, v * 41, 0.1f, 41, 92, n);
  *speckle += 0.5f * n[0];
  return height;
}

static uint8_t to_byte(float value) {
  float scaled = 127.5f * (1 + value);
  return (uint8_t)(scaled < 0 ? 0 : scaled > 255 ? 255 : scaled + 0.5f);
}

void render_detail_map(uint8_t* texels) {
  enum { SIZE = RENDER_DETAIL_SIZE };
  float* heights = malloc(sizeof(float) * SIZE * SIZE);
  if (heights == NULL) {
    for (size_t i = 0; i < (size_t)4 * SIZE * SIZE; ++i) texels[i] = 128;
    return;
  }
  for (int y = 0; y < SIZE; ++y)
    for (int x = 0; x < SIZE; ++x) {
      float speckle;
      heights[y * SIZE + x] = grain(((float)x + 0.5f) / SIZE, ((float)y + 0.5f) / SIZE, &speckle);
      texels[4 * (y * SIZE + x) + 3] = to_byte(speckle);
    }
  for (int y = 0; y < SIZE; ++y)
    for (int x = 0; x < SIZE; ++x) {
      const float* row = heights + y * SIZE;
      float by_u = (row[(x + 1) % SIZE] - row[(x + SIZE - 1) % SIZE]) * (SIZE * 0.5f);
      float by_v = (heights[(y + 1) % SIZE * SIZE + x] - heights[(y + SIZE - 1) % SIZE * SIZE + x]) * (SIZE * 0.5f);
      uint8_t* texel = texels + 4 * (y * SIZE + x);
      texel[0] = to_byte(by_u);
      texel[1] = to_byte(by_v);
      texel[2] = to_byte(row[x] * 60);
    }
  free(heights);
}

uint32_t render_noise_texture(void) {
  float* texels = malloc(sizeof(float) * 4 * RENDER_NOISE_SIZE * RENDER_NOISE_SIZE * RENDER_NOISE_SIZE);
  if (texels == NULL) return 0;
  render_noise_volume(texels);
  GLuint texture = 0;
  glGenTextures(1, &texture);
  glBindTexture(GL_TEXTURE_3D, texture);
  glTexImage3D(GL_TEXTURE_3D, 0, GL_RGBA16F, RENDER_NOISE_SIZE, RENDER_NOISE_SIZE, RENDER_NOISE_SIZE, 0, GL_RGBA, GL_FLOAT, texels);
  glGenerateMipmap(GL_TEXTURE_3D);
  glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  free(texels);
  return texture;
}

uint32_t render_detail_texture(void) {
  uint8_t* texels = malloc((size_t)4 * RENDER_DETAIL_SIZE * RENDER_DETAIL_SIZE);
  if (texels == NULL) return 0;
  render_detail_map(texels);
  GLuint texture = 0;
  glGenTextures(1, &texture);
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, RENDER_DETAIL_SIZE, RENDER_DETAIL_SIZE, 0, GL_RGBA, GL_UNSIGNED_BYTE, texels);
  glGenerateMipmap(GL_TEXTURE_2D);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  free(texels);
  return texture;
}
