// Sky, haze and the light that comes from them.
vec3 sky_radiance(vec3 direction) {
  float height = max(direction.y, 0.0);
  vec3 colour = mix(sky_horizon.rgb, sky_zenith.rgb, 1.0 - exp2(-6.0 * height));
  colour = mix(colour, sky_haze.rgb, exp2(-18.0 * height));
  float towards = max(dot(direction, sun.xyz), 0.0);
  colour *= 1.25; // the sky is bright beside what it lights
  return colour + sun_colour.rgb * (0.05 * pow(towards, 6.0) + 0.10 * pow(towards, 48.0) + 2.0 * pow(towards, 4000.0));
}

// Light of the open sky on a surface with this normal, as the radiance of a white surface.
vec3 sky_light(vec3 normal) {
  float upward = normal.y * 0.5 + 0.5;
  vec3 dome = mix(0.80 * sky_horizon.rgb, mix(sky_horizon.rgb, sky_zenith.rgb, 0.5), smoothstep(0.25, 1.0, upward));
  dome += 0.05 * sun_colour.rgb * max(dot(normalize(normal + vec3(0.0, 0.4, 0.0)), sun.xyz), 0.0);
  return dome * upward * 0.68;
}

// Light that the sunlit ground throws back up.
vec3 ground_light(vec3 normal) {
  return ground_colour.rgb * (0.5 - 0.5 * normal.y) * (0.34 * sun_colour.rgb * max(sun.y, 0.0) + 0.35 * sky_horizon.rgb);
}

// What the air between the eye and a point does to its colour.
vec3 through_air(vec3 colour, vec3 direction, float metres) {
  float towards = max(dot(direction, sun.xyz), 0.0);
  vec3 haze = 1.25 * mix(sky_haze.rgb, sky_horizon.rgb, 0.2) + sun_colour.rgb * (0.05 * towards * towards * towards);
  return mix(haze, colour, exp2(-1.442695 * air.x * metres));
}
