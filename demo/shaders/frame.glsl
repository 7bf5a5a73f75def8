// What every pass of one sample shares. Mirrors struct frame_block in render.c, std140.
// Space: metres from the scene's origin, +Y up. "sample" is one of the jittered pictures that are averaged.
layout(std140) uniform Frame {
  mat4 clip_from_world;      // with this sample's sub-pixel jitter
  mat4 shadow_from_world[3]; // into [0, 1]^3 of a cascade
  vec4 cascade[3];           // x: metres per texel, y: depth range in metres
  vec4 eye;                  // w: metres across one pixel at distance 1
  vec4 right;                // times the tangent of half the horizontal field of view
  vec4 up;                   // times the tangent of half the vertical field of view
  vec4 forward;
  vec4 size;                 // width, height, 1 / width, 1 / height
  vec4 jitter;               // xy: of this sample, in clip space; zw: numbers in [0, 1) that fill the square as samples are added
  vec4 sun;                  // towards the sun; w: tangent of the angle that its radius is drawn with
  vec4 sun_colour;           // radiance of a white surface that faces it
  vec4 sky_zenith;           // all colours are linear, Rec. 709
  vec4 sky_horizon;
  vec4 sky_haze;
  vec4 ground_colour;        // w: 1 if the ground is of sand
  vec4 ground;               // x: height, y: 1 if there is one, z: size of its stones in metres
  vec4 water;                // rgb: colour, w: 1 if the ground is water
  vec4 occlusion;            // x: radius in metres, y: largest radius in pixels, z: slices, w: strength
  vec4 air;                  // x: extinction per metre, y: exposure
  ivec4 mode;                // x: what colours a stone, y: samples accumulated, z: number of cascades in use
};

const uint KIND_SKY = 0u;
const uint KIND_STONE = 1u;
const uint KIND_GROUND = 2u;
const uint KIND_TERRAIN = 3u;
const uint KIND_WATER = 4u;
const uint KIND_MODEL = 5u; // a hoodoo, or an asset of somebody else's; cliffs are stone

// The tags of a pixel. x: hash. y: level of detail in bits 0..3, wireframe in 4, kind in 8..11, logarithm of the cell size in
// 16..31. z: row of the stone + 1. w: sRGB colour in three bytes, code of the corner cube in the fourth. Models: 1 in bit 12 of y
// when painted, the share of colluvium in 13..15; in the fourth byte of w the curvature, 128 = flat.
uint tag_lod(uvec4 tags) { return tags.y & 15u; }
bool tag_wire(uvec4 tags) { return (tags.y >> 4 & 1u) != 0u; }
uint tag_kind(uvec4 tags) { return tags.y >> 8 & 15u; }
float tag_size(uvec4 tags) { return exp2(float(tags.y >> 16) * (1.0 / 1024.0) - 32.0); }
uint tag_tile(uvec4 tags) { return tags.w >> 24; }
vec3 tag_colour(uvec4 tags) {
  vec3 c = vec3(uvec3(tags.w, tags.w >> 8, tags.w >> 16) & 255u) * (1.0 / 255.0);
  return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c));
}

// The view ray of a pixel centre, scaled to view depth 1.
vec3 pixel_ray(vec2 pixel) {
  vec2 clip = pixel * size.zw * 2.0 - 1.0 - jitter.xy;
  return forward.xyz + clip.x * right.xyz + clip.y * up.xyz;
}

// Finaliser with full avalanche (Mueller), for values that differ from stone to stone.
uint hash_bits(uint x) {
  x ^= x >> 16;
  x *= 0x45d9f3bu;
  x ^= x >> 16;
  x *= 0x45d9f3bu;
  x ^= x >> 16;
  return x;
}

float hash_unit(uint x) { return float(hash_bits(x) >> 8) * (1.0 / 16777216.0); }

vec3 hash_vector(uint x) { return vec3(hash_unit(x), hash_unit(x + 0x9e3779b9u), hash_unit(x + 0x3c6ef372u)); }

// Interleaved gradient noise (Jimenez 2014), moved on by the golden ratio from sample to sample.
float pixel_noise(vec2 pixel, float shift) {
  return fract(fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715)))) + shift);
}
