// One full-screen pass that turns what a pixel sees into light.
uniform sampler2D surface_map;
uniform usampler2D tags_map;
uniform sampler2D depth_map;
uniform sampler2D occlusion_map;

out vec4 radiance;

vec3 hue(float turn) { return clamp(abs(fract(turn + vec3(0.0, 2.0 / 3.0, 1.0 / 3.0)) * 6.0 - 3.0) - 1.0, 0.0, 1.0); }

// Colours that tell, instead of stone: by level of detail or by the code of the corner cube.
vec3 tell_colour(uvec4 tags, out bool told) {
  told = true;
  if (mode.x == 1) {
    const vec3 LEVELS[6] = vec3[6](vec3(0.13, 0.50, 0.20), vec3(0.55, 0.58, 0.10), vec3(0.70, 0.33, 0.06), vec3(0.62, 0.10, 0.08),
                                   vec3(0.42, 0.10, 0.45), vec3(0.12, 0.17, 0.55));
    return LEVELS[min(tag_lod(tags), 5u)];
  }
  if (mode.x == 2) {
    uint code = tag_kind(tags) == KIND_MODEL ? tags.x : tag_tile(tags);
    float turn = hash_unit(code * 7u + 3u);
    return mix(vec3(0.36), hue(turn) * 0.7, mix(0.35, 0.85, hash_unit(code * 7u + 4u))) * mix(0.55, 1.0, hash_unit(code * 7u + 5u));
  }
  told = false;
  return vec3(0.0);
}

// Rough stone does not darken towards its rim as paper would. Based on: Oren and Nayar 1994, in the form of Fujii.
float rough_diffuse(vec3 normal, vec3 view) {
  float s = dot(sun.xyz, view) - dot(normal, sun.xyz) * dot(normal, view);
  float t = s <= 0.0 ? 1.0 : max(dot(normal, sun.xyz), dot(normal, view));
  const float SIGMA = 0.55;
  return max(dot(normal, sun.xyz), 0.0) * (1.0 / (1.0 + 0.287793 * SIGMA)) * (1.0 + SIGMA * s / max(t, 1e-3));
}

// Still water with ripples of two lengths.
Surface water_surface(vec3 point, float pixel) {
  vec3 slope = 0.020 * noise(point * 1.3, pixel * 1.3).yzw + 0.012 * (noise(MIX * point * 4.7, pixel * 4.7).yzw * MIX);
  Surface result;
  result.normal = normalize(vec3(0.0, 1.0, 0.0) - vec3(slope.x, 0.0, slope.z));
  result.albedo = water.rgb;
  result.cavity = 0.0;
  return result;
}

// Hoodoos; what is painted stays as it is.
Surface model_surface(uvec4 tags, vec3 point, vec3 normal, float pixel) {
  if ((tags.y >> 12 & 1u) != 0u) return Surface(tag_colour(tags), normal, 0.0);
  float loose = float(tags.y >> 13 & 7u) / 7.0, bend = (float(tags.w >> 24) - 128.0) / 127.0;
  return sandstone_surface(point, normal, tag_colour(tags), loose, bend, tags.x, pixel);
}

// What water mirrors: the sky overhead, and what stands round it lower down.
vec3 mirrored(vec3 direction, vec3 normal) {
  vec3 way = reflect(direction, normal);
  vec3 banks = ground_colour.rgb * (0.22 * sun_colour.rgb * max(sun.y, 0.0) + 0.35 * sky_horizon.rgb);
  return mix(banks, sky_radiance(normalize(vec3(way.x, abs(way.y), way.z))), smoothstep(0.10, 0.60, way.y));
}

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  float depth = texelFetch(depth_map, texel, 0).r;
  vec3 ray = pixel_ray(gl_FragCoord.xy);
  float ray_length = length(ray);
  vec3 direction = ray / ray_length;
  if (depth <= 0.0) {
    radiance = vec4(min(sky_radiance(direction), vec3(8.0)), 1.0);
    return;
  }
  vec4 seen = texelFetch(surface_map, texel, 0);
  uvec4 tags = texelFetch(tags_map, texel, 0);
  vec3 normal = normalize(seen.xyz);
  vec3 view = -direction;
  vec3 point = eye.xyz + ray * depth;
  float distance_to_eye = depth * ray_length;
  // A pixel covers more of a surface that is seen at a slant; half of the way is where neither shimmer nor mush is seen.
  float pixel = distance_to_eye * eye.w * inversesqrt(max(abs(dot(normal, view)), 0.06));
  float cell = tag_size(tags);
  uint kind = tag_kind(tags);

  Surface surface;
  if (kind == KIND_WATER)
    surface = water_surface(point, pixel);
  else if (kind == KIND_STONE)
    surface = stone_surface(point, normal, tag_colour(tags), cell, tags.x, pixel);
  else if (kind == KIND_MODEL)
    surface = model_surface(tags, point, normal, pixel);
  else
    surface = ground_surface(point, normal, clamp(ground.z, 0.25, 1.5), pixel);

  // The pattern of the taps goes with a mean over the neighbours on the same surface: the noise is made for three by three.
  float open = 0.0, total = 0.0;
  for (int v = -1; v <= 1; ++v)
    for (int u = -1; u <= 1; ++u) {
      ivec2 at = clamp(texel + ivec2(u, v), ivec2(0), ivec2(size.xy) - 1);
      float near = texelFetch(depth_map, at, 0).r;
      float weight = abs(near - depth) < 0.02 * depth + 4.0 * pixel ? 1.0 : 0.0;
      open += weight * texelFetch(occlusion_map, at, 0).r;
      total += weight;
    }
  open /= max(total, 1.0);
  open = mix(1.0, open, occlusion.w);
  float baked = kind == KIND_STONE || kind == KIND_MODEL ? seen.w : 1.0;
  open = pow(open, 1.6); // what lies beyond the search hides some sky, too
  float ambient = open * mix(1.0, baked, 0.9) * (1.0 - 0.30 * surface.cavity);

  if (kind == KIND_STONE || kind == KIND_MODEL) {
    bool told;
    vec3 colour = tell_colour(tags, told);
    if (told) surface.albedo = colour;
    // Earth splashes up the lowest stones.
    else if (kind == KIND_STONE && ground.y > 0.5) {
      float height = (point.y - ground.x) / cell;
      float dirt = exp2(-6.0 * max(height, 0.0)) * 0.45;
      surface.albedo = mix(surface.albedo, ground_colour.rgb * 0.8, dirt);
    }
    // Stones that stand in water are wet a hand above it.
    else if (kind == KIND_STONE && water.w > 0.5)
      surface.albedo *= mix(0.50, 1.0, smoothstep(0.02, 0.16, (point.y - ground.x) / cell));
  }

  float turn = pixel_noise(gl_FragCoord.xy + 5.0, jitter.w);
  float lit = sunlight(point, normal, turn);
  // A bump that faces the sun on a side that does not would glow: let the surface itself decide.
  lit *= smoothstep(0.0, 0.12, dot(normal, sun.xyz));
  float direct = rough_diffuse(surface.normal, view) * lit * (1.0 - 0.35 * surface.cavity);

  // Light that bounces between stones brightens pale ones and takes their colour (Jimenez et al. 2016, section 5).
  vec3 a = 2.0404 * surface.albedo - 0.3324, b = -4.7951 * surface.albedo + 0.6417, c = 2.7552 * surface.albedo + 0.6903;
  vec3 bounced = max(vec3(ambient), ((ambient * a + b) * ambient + c) * ambient);

  vec3 colour = surface.albedo * (sun_colour.rgb * direct + (sky_light(surface.normal) + ground_light(surface.normal)) * bounced);
  if (kind == KIND_WATER) {
    float slant = 1.0 - clamp(dot(surface.normal, view), 0.0, 1.0);
    colour = mix(colour, mirrored(direction, surface.normal) * mix(0.5, 1.0, open), 0.02 + 0.98 * slant * slant * slant * slant * slant);
  }
  if (tag_wire(tags)) colour = mix(colour, vec3(0.02, 0.03, 0.04), 0.8);
  colour = through_air(colour, direction, distance_to_eye);
  radiance = vec4(min(colour, vec3(8.0)), 1.0);
}
