// What a model is made of: its bed, what lies on it, or what it is painted with, as one colour and a curvature for the light pass.
in vec3 v_normal;
in float v_visibility;
in float v_depth;
in vec3 v_point;
in vec4 v_rock;
flat in uvec4 v_tags;

uniform uint extra_tags;
uniform int look; // render_look

layout(location = 0) out vec4 surface; // normal, baked visibility
layout(location = 1) out uvec4 tags;
layout(location = 2) out float depth; // along the view axis, metres

vec3 srgb(vec3 x) { return mix(12.92 * x, 1.055 * pow(max(x, 0.0031308), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, x)); }

// Every bed has a tint of its own, the same in all hoodoos of a pack.
vec3 bed_tint(float bed) {
  uint h = uint(bed + 0.5) * 2654435761u + 97u;
  vec3 tint = mix(vec3(0.97, 0.89, 0.84), vec3(1.06, 1.09, 1.10), hash_unit(h));
  return tint * mix(0.92, 1.07, hash_unit(h + 5u));
}

vec3 rock_colour(vec3 base, float pixel) {
  // Beds are not ruled with a straightedge.
  float wave = 0.45 * noise(v_point * vec3(0.45, 0.2, 0.45), pixel * 0.45).x + 0.25 * noise(v_point * vec3(1.7, 0.8, 1.7), pixel * 1.7).x;
  float bed = max(v_rock.x + wave, 0.0), whole = floor(bed);
  vec3 albedo = base * mix(bed_tint(whole), bed_tint(whole + 1.0), smoothstep(0.35, 0.65, bed - whole));
  albedo *= mix(vec3(0.97, 0.94, 0.91), vec3(1.04, 1.05, 1.06), smoothstep(0.6, 1.8, v_rock.z));
  vec3 pale = mix(base, vec3(dot(base, vec3(0.2126, 0.7152, 0.0722))), 0.30) * 1.22;
  if (ground_colour.w > 0.5) pale = mix(pale, ground_colour.rgb * 1.04, 0.65);
  float edge = v_rock.y + 0.30 * noise(v_point * 3.1, pixel * 3.1).x + 0.15 * noise(v_point * 9.0, pixel * 9.0).x;
  return mix(albedo, pale, smoothstep(0.35, 0.65, edge) * step(0.001, v_rock.y));
}

// Where frost broke a cliff, the rock is fresh: warmer and paler than the skin that has seen the weather.
vec3 cliff_colour(vec3 base, float pixel) {
  float stain = noise(v_point * vec3(0.21, 0.07, 0.21), pixel * 0.21).x + 0.5 * noise(v_point * 0.83, pixel * 0.83).x;
  vec3 skin = base * mix(vec3(0.74, 0.76, 0.80), vec3(0.94, 0.93, 0.91), smoothstep(-0.5, 0.5, stain));
  vec3 fresh = base * mix(vec3(1.02, 0.97, 0.90), vec3(1.16, 1.12, 1.06), smoothstep(-0.6, 0.6, stain));
  vec3 albedo = mix(skin, fresh, v_rock.x);
  return albedo * (1.0 + 0.9 * clamp(v_rock.z - 1.0, -0.5, 0.5)) * (1.0 + 0.15 * max(v_rock.w, 0.0));
}

void main() {
  vec3 colour = v_rock.rgb;
  uint bits = 1u << 12, last = 128u;
  if (look == 3) {
    colour = srgb(clamp(cliff_colour(tag_colour(v_tags), v_depth * eye.w), 0.0, 1.0));
    bits = 0u;
    last = v_tags.w >> 24;
  } else if (look != 2) {
    colour = srgb(clamp(rock_colour(tag_colour(v_tags), v_depth * eye.w), 0.0, 1.0));
    bits = uint(clamp(v_rock.y, 0.0, 1.0) * 7.0 + 0.5) << 13;
    last = uint(clamp(v_rock.w, -1.0, 1.0) * 127.0 + 128.5);
  }
  uvec3 bytes = uvec3(clamp(colour, 0.0, 1.0) * 255.0 + 0.5);
  surface = vec4(normalize(v_normal), v_visibility);
  tags = uvec4(v_tags.x, v_tags.y | bits | extra_tags, v_tags.z, bytes.r | bytes.g << 8 | bytes.b << 16 | last << 24);
  depth = v_depth;
}
