// The ground: dry sand with thin grass in patches; it fades to its mean colour with distance.
Surface ground_surface(vec3 point, vec3 normal, float unit, float pixel) {
  vec3 q = point / unit;
  float footprint = pixel / unit;
  vec4 wide = noise(q * 0.031, footprint * 0.031);
  vec4 broad = noise(MIX * q * 0.17, footprint * 0.17);
  vec4 medium = noise(q * 0.93, footprint * 0.93);
  vec4 fine = noise(MIX * q * 4.1, footprint * 4.1);
  vec4 sand = noise(q * 17.0, footprint * 17.0);

  vec3 slope = 0.08 * 0.17 * (broad.yzw * MIX) + 0.040 * 0.93 * medium.yzw + 0.014 * 4.1 * (fine.yzw * MIX) + 0.0060 * 17.0 * sand.yzw;
  float pit;
  vec4 grain = triplanar_detail(q * 0.55, normal, footprint * 0.55, pit);
  slope += 0.55 * grain.xyz;

  // Far away, patches would join into stripes.
  float near = exp2(-length(point - eye.xyz) / (60.0 * unit));
  broad.x *= near;
  wide.x *= near;

  vec3 mean = 0.86 * ground_colour.rgb;
  vec3 earth = mean * mix(vec3(1.16, 1.10, 1.12), vec3(0.88, 0.84, 0.82), smoothstep(-0.40, 0.40, broad.x + 0.6 * medium.x + 0.5 * fine.x));
  float grass = smoothstep(-0.05, 0.45, 0.7 * wide.x + 0.7 * broad.x + 0.30 * medium.x + 0.35 * fine.x + 0.25 * sand.x);
  vec3 green = mean * mix(vec3(0.58, 0.70, 0.44), vec3(0.92, 0.98, 0.72), clamp(0.5 + 0.8 * fine.x + 0.9 * sand.x, 0.0, 1.0));
  vec3 albedo = mix(earth, green, 0.75 * grass);
  albedo *= 1.0 + 0.10 * medium.x + 0.24 * fine.x + 0.40 * sand.x + 0.30 * grain.w;

  Surface result;
  slope -= normal * dot(slope, normal);
  result.normal = normalize(normal - slope * mix(1.0, 1.4, grass));
  result.albedo = albedo;
  result.cavity = 0.0;
  return result;
}
