// Ambient occlusion from the depth buffer: the cosine-weighted share of the hemisphere above the horizons that are found on either
// side of a few slices. Based on: Jimenez et al., Practical Realtime Strategies for Accurate Indirect Occlusion, 2016.
uniform sampler2D surface_map;
uniform sampler2D depth_map;

out float visibility;

const int STEPS = 5;

vec3 position_at(vec2 pixel, float depth) { return pixel_ray(pixel) * depth; }

void main() {
  vec2 pixel = gl_FragCoord.xy;
  float depth = texelFetch(depth_map, ivec2(pixel), 0).r;
  if (depth <= 0.0) {
    visibility = 1.0;
    return;
  }
  vec3 normal = texelFetch(surface_map, ivec2(pixel), 0).xyz;
  vec3 here = position_at(pixel, depth);
  here += normal * length(here) * eye.w * 0.5;
  vec3 view = -normalize(here);
  vec3 across = normalize(right.xyz), upward = normalize(up.xyz);

  float radius = occlusion.x;
  float pixels = radius / (depth * eye.w);
  if (pixels > occlusion.y) {
    radius *= occlusion.y / pixels;
    pixels = occlusion.y;
  }
  if (pixels < 1.5) {
    visibility = 1.0;
    return;
  }
  int slices = int(occlusion.z);
  float turn = pixel_noise(pixel, jitter.z);
  float start = pixel_noise(pixel + 17.0, jitter.w);
  float total = 0.0;
  for (int slice = 0; slice < slices; ++slice) {
    float angle = (float(slice) + turn) * 3.14159265 / float(slices);
    vec2 step_direction = vec2(cos(angle), sin(angle));
    vec3 direction = across * step_direction.x + upward * step_direction.y;
    vec3 in_slice = direction - view * dot(direction, view);
    vec3 axis = normalize(cross(direction, view));
    vec3 projected = normal - axis * dot(normal, axis);
    float projected_length = max(length(projected), 1e-4);
    float cosine = clamp(dot(projected, view) / projected_length, -1.0, 1.0);
    float tilt = sign(dot(in_slice, projected)) * acos(cosine);

    vec2 horizon = cos(vec2(tilt + 1.57079633, tilt - 1.57079633));
    vec2 lowest = horizon;
    for (int side = 0; side < 2; ++side) {
      float way = side == 0 ? 1.0 : -1.0;
      for (int i = 0; i < STEPS; ++i) {
        float along = (float(i) + start) / float(STEPS);
        vec2 tap = pixel + way * step_direction * max(along * along * pixels, float(i) + 1.0);
        if (any(lessThan(tap, vec2(0.0))) || any(greaterThanEqual(tap, size.xy))) break;
        float tap_depth = texelFetch(depth_map, ivec2(tap), 0).r;
        if (tap_depth <= 0.0) continue;
        vec3 delta = position_at(floor(tap) + 0.5, tap_depth) - here;
        float away = length(delta);
        // Taps sit on pixel centres, a little beside the slice: on a slanted plane they would seem to rise above it.
        if (dot(delta, normal) < 0.06 * away) continue;
        float weight = clamp(2.0 - 2.0 * away / radius, 0.0, 1.0);
        float rise = mix(lowest[side], dot(delta, view) / away, weight);
        horizon[side] = max(horizon[side], rise);
      }
    }
    // Side 0 lies at positive angles of the slice, side 1 at negative ones.
    float h0 = tilt + clamp(acos(clamp(horizon.x, -1.0, 1.0)) - tilt, -1.57079633, 1.57079633);
    float h1 = tilt + clamp(-acos(clamp(horizon.y, -1.0, 1.0)) - tilt, -1.57079633, 1.57079633);
    float arc = (cosine + 2.0 * h0 * sin(tilt) - cos(2.0 * h0 - tilt)) + (cosine + 2.0 * h1 * sin(tilt) - cos(2.0 * h1 - tilt));
    total += projected_length * arc * 0.25;
  }
  visibility = clamp(total / float(slices), 0.0, 1.0);
}
