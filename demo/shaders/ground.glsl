// The ground: dry earth with thin grass. Its noise has no scale of its own: whatever the distance, there are octaves of about 5 to
// 80 pixels, each faded in and out as the eye comes nearer, so that a close view is never smooth and a far one never stripes.
Surface ground_surface(vec3 point, vec3 normal, float unit, float pixel) {
  float level = max(log2(pixel * 5.0), log2(unit * 0.04));
  // Seen at a slant, isotropic noise is a pattern of stripes: let it go towards the horizon.
  float slant = smoothstep(0.015, 0.16, abs(dot(normal, normalize(point - eye.xyz))));
  float whole = floor(level), part = level - whole;
  float wavelength = exp2(whole);
  float small = 0.0, large = 0.0;
  vec3 slope = vec3(0.0), q = point;
  mat3 back = mat3(1.0);
  for (int i = 0; i < 5; ++i) {
    vec4 n = noise(q / wavelength, pixel / wavelength);
    float weight = i == 0 ? 1.0 - part : i == 4 ? part : 1.0;
    if (i < 3) small += weight * n.x;
    if (i > 0) large += weight * n.x;
    slope += weight * 0.055 * (n.yzw * back);
    q = MIX * q;
    back = MIX * back;
    wavelength *= 2.0;
  }
  small *= slant;
  large *= slant;
  slope *= slant;
  // Patches of grass keep their place in the world.
  vec4 wide = noise(point / (unit * 23.0), pixel / (unit * 23.0));
  vec4 broad = noise(MIX * point / (unit * 6.0), pixel / (unit * 6.0));
  float pit;
  vec4 grain = triplanar_detail(point / (unit * 1.6), normal, pixel / (unit * 1.6), pit);
  slope += 0.5 * grain.xyz;

  // Greener colours are less so: a lawn is not what stones lie on.
  float grey = dot(ground_colour.rgb, vec3(0.2126, 0.7152, 0.0722));
  vec3 mean = 0.80 * mix(ground_colour.rgb, vec3(1.06, 1.0, 0.78) * grey, 0.40);
  float steep = smoothstep(0.96, 0.72, normal.y);
  float grass = smoothstep(-0.30, 0.55, slant * (0.7 * wide.x + 0.6 * broad.x) + 0.55 * large + 0.35 * small - 0.5 * steep);
  vec3 earth = mean * mix(vec3(1.30, 1.14, 1.02), vec3(0.88, 0.80, 0.74), smoothstep(-0.5, 0.5, large + 0.6 * broad.x));
  vec3 green = mean * mix(vec3(0.58, 0.66, 0.44), vec3(0.90, 0.95, 0.66), clamp(0.5 + 0.9 * small, 0.0, 1.0));
  vec3 albedo = mix(earth, green, 0.85 * grass);
  albedo *= max(1.0 + 0.36 * small + 0.30 * grain.w, 0.2);

  // Sand instead: ripples that the wind makes, patches of coarser grain, nothing that grows.
  if (ground_colour.w > 0.5) {
    vec2 across = vec2(0.83, 0.56);
    float bent = dot(point.xz, across) + 0.35 * broad.x + 0.10 * noise(point * 1.3, pixel * 1.3).x;
    vec4 ripple = noise(vec3(bent * 7.0, 0.5, dot(point.xz, vec2(-across.y, across.x)) * 0.8), pixel * 7.0);
    float blown = smoothstep(-0.15, 0.30, wide.x + 0.5 * broad.x) * slant;
    slope = 0.45 * slope + 0.35 * grain.xyz;
    slope.xz += blown * 0.16 * ripple.y * across;
    mean = ground_colour.rgb;
    // Grains that are too coarse for the wind lie where it blows most.
    float specks = noise(point * 17.0, pixel * 17.0).x + 0.4 * noise(MIX * point * 5.0, pixel * 5.0).x;
    float pebbles = smoothstep(0.30, 0.42, specks) * smoothstep(0.25, -0.25, wide.x + 0.6 * broad.x);
    albedo = mean * mix(vec3(1.06, 1.05, 1.04), vec3(0.90, 0.85, 0.81), smoothstep(-0.35, 0.45, 0.5 * large + 0.9 * wide.x + 0.3 * broad.x));
    albedo *= max(1.0 + 0.09 * large + 0.10 * small + 0.30 * grain.w + blown * 0.08 * ripple.x - 0.38 * pebbles, 0.2);
    slope *= 1.0 + pebbles;
    mean *= vec3(0.95, 0.76, 0.64);
    grass = 0.0;
    unit = max(unit, 1.1); // walls of rock do not grow finer with the stones before them
  }

  // Where it is too steep for earth the rock shows: beds that run level, cracks that run down.
  float cliff = smoothstep(0.74, 0.52, normal.y);
  if (cliff > 0.0) {
    vec3 p = point / unit;
    float footprint = pixel / unit;
    vec4 bend = noise(p * vec3(0.09, 0.0, 0.09) + 5.0, footprint * 0.09);
    vec4 thick = noise(vec3(p.xz * 0.02, p.y * 0.33 + 0.9 * bend.x).xzy, footprint * 0.33);
    vec4 thin = noise(vec3(p.xz * 0.05, p.y * 1.4 + 1.6 * bend.x).xzy, footprint * 1.4);
    vec4 crack = noise(p * vec3(0.85, 0.035, 0.85) + 0.3 * bend.x, footprint * 0.85);
    vec4 block = noise(MIX * p * 1.9, footprint * 1.9);
    float joint = smoothstep(0.09, 0.0, abs(crack.x)) * smoothstep(-0.2, 0.3, thin.x) * (1.0 - smoothstep(0.1, 0.5, footprint));
    vec3 rock = mean * mix(vec3(1.34, 1.12, 0.94), vec3(0.86, 0.68, 0.58), smoothstep(-0.35, 0.35, thick.x + 0.35 * thin.x));
    rock *= (1.0 + 0.22 * thin.x + 0.16 * block.x + 0.25 * grain.w) * (1.0 - 0.30 * joint);
    albedo = mix(albedo, rock, cliff);
    vec3 relief = 0.20 * thick.yzw + 0.26 * thin.yzw + 0.22 * crack.yzw + 0.18 * (block.yzw * MIX);
    slope = mix(slope, relief + 0.5 * grain.xyz, cliff);
    grass *= 1.0 - cliff;
  }

  Surface result;
  slope -= normal * dot(slope, normal);
  result.normal = normalize(normal - slope * mix(1.0, 1.5, grass));
  result.albedo = max(albedo, 0.01);
  result.cavity = 0.0;
  return result;
}
