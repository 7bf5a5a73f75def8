// Weathered sandstone and what crumbles off it: thin layers that run level, rills that run down, grains; nothing that is broken.
// loose: the share of colluvium; bend: curvature, -1 hollows .. 1 edges; pixel: metres that a pixel covers here.
Surface sandstone_surface(vec3 point, vec3 normal, vec3 colour, float loose, float bend, uint hash, float pixel) {
  vec3 q = point + hash_vector(hash) * 8.0;
  float wall = (1.0 - normal.y * normal.y) * (1.0 - loose);
  vec4 broad = noise(q * 0.9, pixel * 0.9);
  vec4 lump = noise(MIX * q * 2.6, pixel * 2.6);
  vec4 small = noise(q * 7.3, pixel * 7.3);
  vec4 fine = noise(MIX * q * 19.0, pixel * 19.0);
  vec3 slope = 0.030 * 2.6 * (lump.yzw * MIX) + 0.010 * 7.3 * small.yzw + 0.0045 * 19.0 * (fine.yzw * MIX);

  // Layers: of the place in the world and not of the hoodoo, for they were there before it.
  float level = point.y + 0.16 * noise(point * vec3(0.5, 0.0, 0.5), pixel * 0.5).x + 0.05 * broad.x + 0.03 * lump.x;
  vec4 thick = noise(vec3(point.x * 0.2, level * 4.3, point.z * 0.2), pixel * 4.3);
  vec4 thin = noise(vec3(point.x * 0.4, level * 15.0, point.z * 0.4), pixel * 15.0);
  slope.y += wall * (0.020 * 4.3 * thick.z + 0.0065 * 15.0 * thin.z);

  // Rills: water comes down the walls in lines.
  vec3 r = q + 0.22 * vec3(broad.y, 0.0, broad.w) + 0.05 * vec3(lump.y, 0.0, lump.w);
  vec4 rill = noise(r * vec3(2.6, 0.30, 2.6), pixel * 2.6);
  vec4 streak = noise(r * vec3(8.0, 0.55, 8.0) + 3.0, pixel * 8.0);
  slope += wall * (0.034 * vec3(2.6, 0.3, 2.6) * rill.yzw + 0.007 * vec3(8.0, 0.45, 8.0) * streak.yzw);
  float pit;
  vec4 grain = triplanar_detail(q * 1.9, normal, pixel * 1.9, pit);
  slope += mix(0.35, 0.60, loose) * grain.xyz;

  vec3 albedo = colour;
  albedo *= 1.0 + 0.13 * broad.x + 0.10 * lump.x + 0.10 * small.x + 0.08 * fine.x;
  albedo *= 1.0 + wall * (0.18 * thick.x + 0.08 * thin.x);
  albedo *= 1.0 - wall * 0.20 * smoothstep(0.05, 0.45, rill.x + 0.3 * streak.x);
  albedo *= 1.0 + mix(0.16, 0.30, loose) * grain.w;
  // Edges are bleached and rubbed, hollows keep the dust and the dark.
  vec3 rubbed = mix(vec3(0.72, 0.68, 0.65), vec3(1.14, 1.14, 1.13), smoothstep(-0.55, 0.55, bend));
  albedo *= mix(rubbed, vec3(1.0), 0.6 * loose);
  // Dust settles on what is level.
  float dust = smoothstep(0.55, 0.95, normal.y + 0.25 * lump.x) * 0.35 * (1.0 - loose);
  if (ground_colour.w > 0.5) albedo = mix(albedo, ground_colour.rgb, dust);

  Surface result;
  float hollow = clamp(0.10 - 0.5 * bend - 0.25 * small.x - 0.5 * pit, 0.0, 1.0);
  result.cavity = hollow * hollow;
  slope -= normal * dot(slope, normal);
  result.normal = normalize(normal - slope);
  result.albedo = clamp(albedo, 0.02, 0.85);
  return result;
}
