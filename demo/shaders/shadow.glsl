// Sunlight with a penumbra that widens with the distance to what casts it.
// Based on: Fernando, Percentage-Closer Soft Shadows, 2005. Where we differ: the sun is a disc at infinity, so a penumbra is metres
// of distance times a tangent; each tap is compared on the receiver's own plane, so that wide filters neither speckle nor need the
// large bias that would lift shadows off their casters.
uniform sampler2DArray shadow_depth;
uniform sampler2DArrayShadow shadow_compare;

const int BLOCKER_TAPS = 8;
const int FILTER_TAPS = 12;

// What lies behind all casters is compared with them, not with the cleared map; float depth is not clamped by itself.
const float FARTHEST = 0.99999;

vec2 vogel(int index, int count, float turn) {
  float angle = (float(index) + turn) * 2.39996323 + turn * 6.2831853;
  return sqrt((float(index) + 0.5) / float(count)) * vec2(cos(angle), sin(angle));
}

// Share of the sun's disc that a point sees. normal: of the surface, not of its bumps.
float sunlight(vec3 point, vec3 normal, float turn) {
  float facing = dot(normal, sun.xyz);
  if (facing <= 0.0) return 0.0;
  for (int c = 0; c < mode.z; ++c) {
    float texel = cascade[c].x;
    float slope = sqrt(1.0 - facing * facing);
    vec3 lifted = point + normal * (texel * (0.4 + 1.1 * slope));
    vec3 place = (shadow_from_world[c] * vec4(lifted, 1.0)).xyz;
    vec2 scale = vec2(length(vec3(shadow_from_world[c][0].x, shadow_from_world[c][1].x, shadow_from_world[c][2].x)),
                      length(vec3(shadow_from_world[c][0].y, shadow_from_world[c][1].y, shadow_from_world[c][2].y)));
    vec2 margin = scale * texel * 3.0;
    if (any(lessThan(place.xy, margin)) || any(greaterThan(place.xy, 1.0 - margin))) continue;

    // The receiver's plane in the shadow map: how depth changes with x and y. Clamped, for it runs away at grazing angles.
    vec3 x_axis = normalize(vec3(shadow_from_world[c][0].x, shadow_from_world[c][1].x, shadow_from_world[c][2].x));
    vec3 y_axis = normalize(vec3(shadow_from_world[c][0].y, shadow_from_world[c][1].y, shadow_from_world[c][2].y));
    vec2 plane = vec2(dot(normal, x_axis), dot(normal, y_axis)) / max(facing, 0.25);
    float depth_range = cascade[c].y;

    float search = clamp(sun.w * 6.0 * ground.z, 2.0 * texel, 24.0 * texel);
    float blockers = 0.0, blocker_gap = 0.0;
    for (int i = 0; i < BLOCKER_TAPS; ++i) {
      vec2 tap = vogel(i, BLOCKER_TAPS, turn) * search;
      float depth = textureLod(shadow_depth, vec3(place.xy + tap * scale, float(c)), 0.0).r;
      float reference = min(place.z + dot(plane, tap) / depth_range, FARTHEST);
      if (depth < reference) {
        blockers += 1.0;
        blocker_gap += (reference - depth) * depth_range;
      }
    }
    if (blockers == 0.0) return 1.0;
    float radius = clamp(blocker_gap / blockers * sun.w, 1.0 * texel, search);
    float lit = 0.0;
    for (int i = 0; i < FILTER_TAPS; ++i) {
      vec2 tap = vogel(i, FILTER_TAPS, turn) * radius;
      lit += texture(shadow_compare, vec4(place.xy + tap * scale, float(c), min(place.z + dot(plane, tap) / depth_range, FARTHEST)));
    }
    return lit / float(FILTER_TAPS);
  }
  return 1.0;
}
