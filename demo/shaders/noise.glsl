// Gradient noise out of a volume texture that repeats after 8 lattice steps, with its derivative; mipmaps take away what is finer
// than a pixel, so that nothing shimmers.
uniform sampler3D noise_volume;
uniform sampler2D detail_map;

// The mean of several samples takes care of what is a little finer than a pixel: mipmaps need not.
const float SHARP = 0.6;

// x: value in about [-0.7, 0.7]; yzw: derivative by p. footprint: metres of a pixel, in units of p.
vec4 noise(vec3 p, float footprint) {
  return textureLod(noise_volume, p * 0.125, log2(max(footprint * SHARP * 8.0, 1.0)));
}

// A rotation that mixes the axes, so that the lattices of two octaves never line up.
const mat3 MIX = mat3(0.00, 0.80, 0.60, -0.80, 0.36, -0.48, -0.60, -0.48, 0.64);
