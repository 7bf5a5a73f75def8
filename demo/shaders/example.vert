#version 450
#extension GL_ARB_shader_draw_parameters : require
// Draws the instances of a stream straight from its structs: no vertex attributes, gl_BaseInstanceARB says which instance.

layout(std430, binding = 0) readonly buffer Meshes { uvec4 vertices[]; };  // scree_vertex, 16 bytes
layout(std430, binding = 1) readonly buffer Instances { uint instances[]; };  // scree_stream_instance, 6 words
layout(std430, binding = 2) readonly buffer Blocks { vec4 blocks[]; };  // two each: origin relative to the eye, metres a
                                                                           // lattice step; level
layout(location = 0) uniform mat4 camera;

out vec3 colour;

vec2 two_int16(uint word) {
  return vec2(bitfieldExtract(int(word), 0, 16), bitfieldExtract(int(word), 16, 16));
}

uint hash(uint x) {
  x = (x ^ x >> 16) * 0x7feb352du;
  x = (x ^ x >> 15) * 0x846ca68bu;
  return x ^ x >> 16;
}

void main() {
  uvec4 vertex = vertices[gl_VertexID];
  vec3 position = vec3(two_int16(vertex.x), two_int16(vertex.y).x);
  float occlusion = float(vertex.y >> 16 & 255u) / 255.0;
  vec3 normal = vec3(two_int16(vertex.z), two_int16(vertex.w).x) / 32767.0;

  uint first = 6u * uint(gl_BaseInstanceARB);
  vec3 place = uintBitsToFloat(uvec3(instances[first], instances[first + 1u], instances[first + 2u]));
  uint random = instances[first + 4u];
  vec4 block = blocks[2u * instances[first + 5u]];
  float level = blocks[2u * instances[first + 5u] + 1u].x;

  vec3 at = position * block.w + place + block.xyz;
  float shade = float(random & 255u) / 255.0;
  if (level > 0.0) { // A proxy stands for many rocks: another shade at each vertex, nearer to the mean the more rocks that is.
    shade = float(hash(vertex.x ^ hash(vertex.y ^ random)) & 255u) / 255.0;
    shade = mix(0.5, shade, 1.4 * exp2(-level));
  }
  vec3 stone = mix(vec3(0.17, 0.14, 0.11), vec3(0.5, 0.45, 0.38), shade);
  vec3 sun = vec3(1.6, 1.4, 1.1) * max(dot(normal, vec3(0.48, 0.64, 0.6)), 0.0);
  vec3 sky = vec3(0.25, 0.35, 0.5) * (0.7 + 0.3 * normal.y) * occlusion;
  vec3 haze = vec3(0.35, 0.5, 0.7);
  colour = mix(haze, stone * (sun * mix(0.5, 1.0, occlusion) + sky), exp(-length(at) / 250.0));
  gl_Position = camera * vec4(at, 1.0);
}
