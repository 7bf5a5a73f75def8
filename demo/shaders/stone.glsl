// Stone: solid noise for the form of the surface, a triplanar map for its grain, and wear that hangs on the place in the world, so
// that the same mesh never looks the same twice.
struct Surface {
  vec3 albedo;
  vec3 normal;
  float cavity; // 0 in the open, 1 in pits and cracks
};

// Grain out of the detail map along the three axes. xyz: slope in the world; w: how much of a speckle (-1 dark .. 1 bright).
vec4 triplanar_detail(vec3 q, vec3 normal, float footprint, out float pit) {
  vec3 weight = pow(abs(normal), vec3(6.0));
  weight /= weight.x + weight.y + weight.z;
  float level = log2(max(footprint * SHARP * 512.0, 1.0));
  vec4 x = textureLod(detail_map, q.zy, level) * 2.0 - 1.0;
  vec4 y = textureLod(detail_map, q.xz, level) * 2.0 - 1.0;
  vec4 z = textureLod(detail_map, q.xy, level) * 2.0 - 1.0;
  pit = dot(weight, vec3(x.z, y.z, z.z));
  vec3 slope = weight.x * vec3(0.0, x.y, x.x) + weight.y * vec3(y.x, 0.0, y.y) + weight.z * vec3(z.x, z.y, 0.0);
  return vec4(slope, dot(weight, vec3(x.w, y.w, z.w)));
}

// point: metres; normal: of the mesh; cell: metres, about the size of a stone; pixel: metres that a pixel covers here.
Surface stone_surface(vec3 point, vec3 normal, vec3 colour, float cell, uint hash, float pixel) {
  vec3 q = point / cell + hash_vector(hash) * 8.0;
  float footprint = pixel / cell;
  float rough = mix(0.7, 1.3, hash_unit(hash + 21u));

  // Form: octaves of noise, the second one creased, so that it reads as broken faces and not as clay.
  vec3 slope = vec3(0.0);
  vec4 broad = noise(q * 1.6, footprint * 1.6);
  slope += 0.045 * 1.6 * broad.yzw;
  vec3 q2 = MIX * q;
  vec4 crease = noise(q2 * 3.9, footprint * 3.9);
  float fold = crease.x * inversesqrt(crease.x * crease.x + 0.0025);
  slope -= 0.024 * 3.9 * rough * fold * (crease.yzw * MIX);
  vec3 q3 = MIX * q2;
  vec4 medium = noise(q3 * 8.7, footprint * 8.7);
  slope += 0.0125 * 8.7 * rough * (medium.yzw * MIX * MIX);
  vec4 fine = noise(q * 21.0, footprint * 21.0);
  slope += 0.0060 * 21.0 * rough * fine.yzw;
  float pit;
  vec4 grain = triplanar_detail(q * 0.8, normal, footprint * 0.8, pit);
  slope += 0.85 * rough * grain.xyz;

  // Strata: beds across an axis of the stone's own, in about every third one.
  vec3 axis = normalize(hash_vector(hash + 31u) - 0.5 + vec3(0.0, 0.35, 0.0));
  float bedded = smoothstep(0.60, 0.95, hash_unit(hash + 32u));
  float bed = dot(q, axis) * 3.3 + 0.40 * broad.x + 0.14 * medium.x;
  vec4 beds = noise(vec3(bed * 1.7, 3.5, hash_unit(hash + 33u) * 8.0), footprint * 5.6);
  slope += bedded * 0.030 * 5.6 * beds.y * axis;

  vec3 albedo = colour;
  vec3 stain = mix(vec3(0.95, 0.96, 0.98), vec3(0.95, 0.89, 0.79), hash_unit(hash + 41u));
  albedo *= mix(vec3(1.0), stain, smoothstep(-0.10, 0.50, broad.x + 0.35 * crease.x));
  albedo *= 1.0 + 0.10 * medium.x + 0.14 * fine.x + 0.25 * pit;
  albedo *= 1.0 + bedded * 0.40 * beds.x;
  float speckle = mix(0.12, 0.42, hash_unit(hash + 42u));
  albedo *= 1.0 + speckle * grain.w;

  // Lichen: crusts on the sides that see the sky, on about a third of the stones, each stone its own kind.
  float habit = smoothstep(0.60, 0.95, hash_unit(hash + 51u));
  if (habit > 0.0) {
    float patches = noise(q * 2.3 + 3.3, footprint * 2.3).x + 0.40 * noise(q * 9.7 + 1.7, footprint * 9.7).x + 0.22 * grain.w;
    float crust = smoothstep(0.20, 0.27, patches + 0.14 * normal.y - 0.10 + 0.10 * habit) * habit;
    float kind = hash_unit(hash + 52u);
    vec3 tint = kind < 0.55 ? vec3(0.34, 0.36, 0.26) : kind < 0.85 ? vec3(0.58, 0.58, 0.53) : vec3(0.44, 0.35, 0.13);
    albedo = mix(albedo, tint * (1.0 + 0.5 * fine.x), 0.60 * crust);
  }

  Surface result;
  float hollow = clamp(0.20 - 0.45 * medium.x - 0.30 * fine.x - 0.8 * pit, 0.0, 1.0);
  result.cavity = hollow * hollow;
  slope -= normal * dot(slope, normal);
  result.normal = normalize(normal - slope);
  result.albedo = clamp(albedo, 0.02, 0.85);
  return result;
}
