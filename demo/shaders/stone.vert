layout(location = 0) in vec3 position; // lattice steps
layout(location = 1) in vec3 normal;
layout(location = 2) in float visibility;
layout(location = 3) in vec4 place; // metres; w: metres per lattice step
layout(location = 4) in uvec4 tags; // hash, tags, stone + 1, bits of the cell size

out vec3 v_normal;
out float v_visibility;
out float v_depth;
flat out uvec4 v_tags;

void main() {
  vec3 world = place.xyz + position * place.w;
  gl_Position = clip_from_world * vec4(world, 1.0);
  v_normal = normal;
  v_visibility = visibility;
  v_depth = dot(world - eye.xyz, forward.xyz);
  v_tags = tags;
}
