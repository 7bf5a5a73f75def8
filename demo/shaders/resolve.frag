// From the sum of samples to the screen: mean, exposure, film curve, sRGB, and a dither that hides the steps of 8 bits in the sky.
uniform sampler2D sum_map;

out vec4 colour;

// Film curve with a toe and a shoulder. Based on: Narkowicz, ACES Filmic Tone Mapping Curve, 2015.
vec3 film(vec3 x) { return clamp((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0); }

vec3 srgb(vec3 x) { return mix(12.92 * x, 1.055 * pow(max(x, 0.0031308), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, x)); }

void main() {
  vec4 sum = texelFetch(sum_map, ivec2(gl_FragCoord.xy), 0);
  vec3 linear = sum.rgb / max(sum.a, 1.0) * air.y;
  // Some of the curve works on brightness, so that bright stones keep their colour.
  float level = max(dot(linear, vec3(0.2126, 0.7152, 0.0722)), 1e-5);
  vec3 by_level = linear * (film(vec3(level)).x / level);
  vec3 mapped = mix(film(linear), clamp(by_level, 0.0, 1.0), 0.35);
  float dither = (pixel_noise(gl_FragCoord.xy, 0.0) - 0.5) / 255.0;
  colour = vec4(srgb(mapped) + dither, 1.0);
}
